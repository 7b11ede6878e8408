//! What is allocated: nothing by a look-up, and little by a file that lies about its size. A binary of its own, because it
//! counts what all its threads allocate; hence one test.

mod hostile;

use brdf_tables::cap::Cap;
use brdf_tables::frame::spherical;
use brdf_tables::table::Table;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Largest request, and number of requests.
static LARGEST: AtomicUsize = AtomicUsize::new(0);
static COUNT: AtomicUsize = AtomicUsize::new(0);

struct Counting;

// SAFETY: everything is passed on to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Relaxed);
        COUNT.fetch_add(1, Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LARGEST.fetch_max(size, Relaxed);
        COUNT.fetch_add(1, Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn allocations() {
    look_ups_do_not_allocate();
    lies_about_sizes_allocate_little();
}

fn look_ups_do_not_allocate() {
    let caps: Vec<Cap> = (0..600)
        .map(|i| Cap::with_half_angle(0.0026 * f64::from(i), f64::from(i), 0.05 + 0.001 * f64::from(i)).unwrap())
        .collect();
    let batch = caps.iter().collect();
    let mut out = vec![0f32; caps.len()];
    for table in hostile::tables() {
        let mut look_up = || {
            let mut sum = 0.0;
            for wo in [spherical(0.3, 1.0), spherical(1.2, 4.0)] {
                table.specular_values(&batch, wo.as_vec3(), &mut out);
                sum += caps.iter().step_by(7).map(|cap| table.value(cap, wo)[0] + table.support(cap)).sum::<f64>();
            }
            sum
        };
        // The rules of the cubature are made on first use.
        let expected = look_up();
        let before = COUNT.load(Relaxed);
        assert_eq!(look_up(), expected);
        let count = COUNT.load(Relaxed) - before;
        // The readable scalar twin of the lobe table lists the lobes of a node; the batch does not.
        if table.representation_name() != "lobes" {
            assert_eq!(count, 0, "{} allocates", table.representation_name());
        }
        let before = COUNT.load(Relaxed);
        table.specular_values(&batch, spherical(0.5, 0.0).as_vec3(), &mut out);
        assert_eq!(COUNT.load(Relaxed) - before, 0, "the batch of {} allocates", table.representation_name());
    }
}

fn lies_about_sizes_allocate_little() {
    for table in hostile::tables() {
        let bytes = table.to_bytes().unwrap();
        for damaged in hostile::absurd_headers(&bytes) {
            LARGEST.store(0, Relaxed);
            let _ = Table::from_bytes(&damaged);
            let largest = LARGEST.load(Relaxed);
            assert!(
                largest <= (1 << 20) + 16 * bytes.len(),
                "{}: {largest} bytes for {}",
                table.representation_name(),
                bytes.len()
            );
        }
    }
}
