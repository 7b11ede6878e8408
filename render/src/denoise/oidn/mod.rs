//! Intel's Open Image Denoise (Áfra, <https://www.openimagedenoise.org>, version 2), loaded when the program runs.

mod find;
mod functions;

use super::layers::{Layer, Layers};
use super::{DenoiseError, Effort, Progress};
use functions::{Functions, Handle};
use std::ffi::{CStr, c_char, c_void};
use std::path::Path;
use std::ptr;
use std::sync::{Mutex, PoisonError};

/// Oldest version with the functions that are used here.
const OLDEST: i32 = 20_000;
/// Oldest version with the fast network.
const WITH_FAST: i32 = 20_300;

/// The values of the C interface (`oidn.h`).
const DEVICE_CPU: i32 = 1;
const FORMAT_FLOAT3: i32 = 3;
const QUALITY_FAST: i32 = 4;
const QUALITY_BALANCED: i32 = 5;
const QUALITY_HIGH: i32 = 6;

/// Memory for one filter, MB: larger pictures are cut into tiles, the same on every machine.
const MEMORY: i32 = 2048;

/// The library and its processor device, ready to work.
#[derive(Debug)]
pub struct Device {
    functions: Functions,
    version: i32,
    /// One filter at a time.
    device: Mutex<Handle>,
}

/// Images by the name that a filter knows them by.
type Inputs<'a> = [(&'static CStr, &'a [[f32; 3]])];

/// What a filter is to know.
#[derive(Clone, Copy)]
struct Options {
    /// Whether colours may be brighter than 1.
    hdr: bool,
    /// Whether albedo and normals have no noise.
    clean_guides: bool,
    quality: i32,
    /// What colours are scaled by for the network; `None`: by what they are.
    exposure: Option<f32>,
}

impl Device {
    /// Loads the library and makes a device; 0 threads: one for each core.
    ///
    /// # Errors
    /// No library, or one that does not work.
    pub fn open(library: Option<&Path>, threads: usize) -> Result<Self, DenoiseError> {
        let (functions, path) = find::load(library)?;
        let refused = |reason: String| DenoiseError::Library { path: path.clone(), reason };
        // SAFETY: a device of the library is made, told its threads, and asked for its version, as its manual has it.
        let (device, error, version) = unsafe {
            let device = (functions.new_device)(DEVICE_CPU);
            if device.is_null() {
                let error = functions.error(device).unwrap_or_default();
                return Err(refused(format!("Open Image Denoise finds no processor that it can use: {error}")));
            }
            (functions.set_device_int)(device, c"numThreads".as_ptr(), i32::try_from(threads).unwrap_or(0));
            // Threads that are tied to cores get in the way of others on the machine.
            (functions.set_device_bool)(device, c"setAffinity".as_ptr(), false);
            (functions.commit_device)(device);
            (device, functions.error(device), (functions.get_device_int)(device, c"version".as_ptr()))
        };
        let this = Self { functions, version, device: Mutex::new(Handle(device)) };
        match error {
            Some(error) => Err(refused(error)),
            None if version < OLDEST => {
                Err(refused(format!("version {}.{} is too old: 2.0 is needed", version / 10_000, version / 100 % 100)))
            }
            None => Ok(this),
        }
    }

    /// A layer without noise.
    ///
    /// # Errors
    /// What the library says.
    pub(super) fn denoise(
        &self,
        layers: &Layers,
        layer: &Layer,
        effort: Effort,
        progress: Progress,
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let (clean_guides, quality) = match effort {
            Effort::Least | Effort::Together if self.version >= WITH_FAST => (layers.clean_guides, QUALITY_FAST),
            Effort::Least | Effort::Together | Effort::Low => (layers.clean_guides, QUALITY_BALANCED),
            // The larger network of OIDN is the one for clean guides at high quality.
            Effort::High => (true, QUALITY_HIGH),
        };
        let inputs: &Inputs = &[(c"color", &layer.mean), (c"albedo", &layers.albedo), (c"normal", &layers.normal)];
        let exposure = layer.level.map(|level| level.exposure);
        let options = Options { hdr: true, clean_guides, quality, exposure };
        self.filter(inputs, [layers.width, layers.height], options, progress)
    }

    /// Runs one filter; negative and broken numbers of its output become black.
    fn filter(
        &self,
        inputs: &Inputs,
        [width, height]: [usize; 2],
        o: Options,
        progress: Progress,
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
        let Functions { set_image, set_filter_bool, set_filter_int, set_filter_float, set_monitor, .. } =
            self.functions;
        let mut out = vec![[0f32; 3]; width * height];
        // SAFETY: the images are `width · height` times three floats without gaps, which the library reads (the output: writes)
        // during `execute` only, as it calls `monitor`; the filter is released before they and `progress` are gone. Names end with 0.
        let error = unsafe {
            let filter = (self.functions.new_filter)(device.0, c"RT".as_ptr());
            let image = |name: *const c_char, data: *mut f32| {
                set_image(filter, name, data.cast(), FORMAT_FLOAT3, width, height, 0, 0, 0);
            };
            if !filter.is_null() {
                for (name, pixels) in inputs {
                    assert_eq!(pixels.len(), width * height, "an image of another size");
                    image(name.as_ptr(), pixels.as_ptr().cast_mut().cast());
                }
                image(c"output".as_ptr(), out.as_mut_ptr().cast());
                set_filter_bool(filter, c"hdr".as_ptr(), o.hdr);
                set_filter_bool(filter, c"cleanAux".as_ptr(), o.clean_guides);
                set_filter_int(filter, c"quality".as_ptr(), o.quality);
                if let Some(exposure) = o.exposure {
                    set_filter_float(filter, c"inputScale".as_ptr(), exposure);
                }
                set_filter_int(filter, c"maxMemoryMB".as_ptr(), MEMORY);
                set_monitor(filter, monitor, (&raw const progress).cast_mut().cast());
                (self.functions.commit_filter)(filter);
                (self.functions.execute_filter)(filter);
                (self.functions.release_filter)(filter);
            }
            self.functions.error(device.0)
        };
        match error {
            Some(error) => Err(DenoiseError::Failed(error)),
            None => Ok(out),
        }
    }
}

/// Passes on what the library tells of its work.
extern "C" fn monitor(progress: *mut c_void, share: f64) -> bool {
    // SAFETY: `filter` gives the address of one, which stands until the filter is released.
    let progress = unsafe { &*progress.cast::<Progress>() };
    progress(share);
    true
}

impl Drop for Device {
    fn drop(&mut self) {
        let device = self.device.get_mut().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: made by `open`, released once.
        unsafe { (self.functions.release_device)(device.0) }
        device.0 = ptr::null_mut();
    }
}
