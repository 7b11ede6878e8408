//! The part of the C interface (`oidn.h`, 2.0 to 2.5) that is used.

use libloading::Library;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;

/// A device of the library.
#[derive(Debug)]
pub(super) struct Handle(pub *mut c_void);

// SAFETY: the library may be called from any thread, by its manual.
unsafe impl Send for Handle {}

/// Is told the share of the work that is done; `false` would end it.
pub(super) type Monitor = extern "C" fn(*mut c_void, f64) -> bool;

macro_rules! functions {
    ($($field:ident: $symbol:literal, fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Functions of the library, which stays loaded.
        #[derive(Debug)]
        pub(super) struct Functions {
            $(pub $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            /// What the functions are of.
            _library: Library,
        }

        impl Functions {
            /// Looks them up.
            ///
            /// # Errors
            /// One line: the first that the library lacks.
            ///
            /// # Safety
            /// The library must be Open Image Denoise, if it has functions of these names.
            pub unsafe fn of(library: Library) -> Result<Self, String> {
                $(
                    // SAFETY: the types are those of `oidn.h`.
                    let $field = *unsafe { library.get::<unsafe extern "C" fn($($argument),*) $(-> $result)?>($symbol) }
                        .map_err(|error| format!("it is not Open Image Denoise 2: {error}"))?;
                )*
                Ok(Self { $($field,)* _library: library })
            }
        }
    };
}

functions! {
    new_device: b"oidnNewDevice\0", fn(c_int) -> *mut c_void;
    release_device: b"oidnReleaseDevice\0", fn(*mut c_void);
    commit_device: b"oidnCommitDevice\0", fn(*mut c_void);
    set_device_int: b"oidnSetDeviceInt\0", fn(*mut c_void, *const c_char, c_int);
    set_device_bool: b"oidnSetDeviceBool\0", fn(*mut c_void, *const c_char, bool);
    get_device_int: b"oidnGetDeviceInt\0", fn(*mut c_void, *const c_char) -> c_int;
    get_device_error: b"oidnGetDeviceError\0", fn(*mut c_void, *mut *const c_char) -> c_int;
    new_filter: b"oidnNewFilter\0", fn(*mut c_void, *const c_char) -> *mut c_void;
    release_filter: b"oidnReleaseFilter\0", fn(*mut c_void);
    commit_filter: b"oidnCommitFilter\0", fn(*mut c_void);
    execute_filter: b"oidnExecuteFilter\0", fn(*mut c_void);
    set_filter_bool: b"oidnSetFilterBool\0", fn(*mut c_void, *const c_char, bool);
    set_filter_int: b"oidnSetFilterInt\0", fn(*mut c_void, *const c_char, c_int);
    set_filter_float: b"oidnSetFilterFloat\0", fn(*mut c_void, *const c_char, f32);
    set_monitor: b"oidnSetFilterProgressMonitorFunction\0", fn(*mut c_void, Monitor, *mut c_void);
    set_image: b"oidnSetSharedFilterImage\0",
        fn(*mut c_void, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
}

impl Functions {
    /// The first error since the last call, in one line. A null device asks for what making one said.
    ///
    /// # Safety
    /// `device` must be one of the library, or null.
    pub unsafe fn error(&self, device: *mut c_void) -> Option<String> {
        let mut message = ptr::null();
        // SAFETY: the library sets `message` to a string that it keeps until the next call.
        let text = unsafe {
            if (self.get_device_error)(device, &raw mut message) == 0 {
                return None;
            }
            if message.is_null() { c"no reason given" } else { CStr::from_ptr(message) }
        };
        Some(text.to_string_lossy().split_whitespace().collect::<Vec<_>>().join(" "))
    }
}
