//! What every fit keeps to, whatever the representation.

use super::*;
use brdf_tables::brdf::{Phong, Ward, WardVariant};
use std::sync::Mutex;

fn attempt(
    specular: Specular,
    representation: Choice,
    tolerance: f64,
    lobes: Option<usize>,
) -> Result<Table, FitError> {
    let (solver, command) = (SolverKind::LevenbergMarquardt, String::new());
    let options = Options {
        representation,
        solver,
        lobes,
        tolerance,
        seed: 1,
        command,
        progress: &|_| ControlFlow::Continue(()),
    };
    super::fit(&Material::specular(specular), &options)
}

#[test]
fn names_parse_back() {
    for choice in Choice::ALL {
        assert_eq!(choice.name().parse(), Ok(choice));
    }
    assert!("lobe".parse::<Choice>().unwrap_err().contains("zonal"));
}

/// A fit that is told to stop does so soon: at its first cell in every representation, and where errors are measured.
#[test]
fn fits_stop_when_told() {
    let phong = Material::specular(Specular::Phong(Phong { exponent: 20.0 }));
    for representation in Choice::ALL {
        let late = if representation == Choice::Auto { &[0.0, 0.5, 0.9, 0.95][..] } else { &[0.0] };
        for &at in late {
            let told = AtomicUsize::new(0);
            let progress = |x| {
                told.fetch_add(usize::from(x > at), Ordering::Relaxed);
                if x > at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let (solver, command) = (SolverKind::LevenbergMarquardt, String::new());
            let options = Options {
                representation,
                solver,
                lobes: Some(1),
                tolerance: 0.01,
                seed: 1,
                command,
                progress: &progress,
            };
            assert!(matches!(super::fit(&phong, &options), Err(FitError::Stopped)), "{representation} {at}");
            let told = told.into_inner();
            assert!(told <= 2 * rayon::current_num_threads(), "{representation} {at}: told {told} times more");
        }
    }
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let phong = Specular::Phong(Phong { exponent: 10.0 });
    let ward = Specular::Ward(Ward { alpha_x: 0.1, alpha_y: 0.5, variant: WardVariant::Ward1992 });
    for tolerance in [0.0, -1.0, 2.0, f64::NAN] {
        assert!(matches!(attempt(phong, Choice::Auto, tolerance, None), Err(FitError::Tolerance(_))));
    }
    for lobes in [0, 17] {
        assert!(matches!(attempt(phong, Choice::Lobes, 0.01, Some(lobes)), Err(FitError::Lobes(_))));
    }
    assert!(matches!(attempt(ward, Choice::Zonal, 0.01, None), Err(FitError::NotRadial)));
    assert!(matches!(attempt(ward, Choice::Paper, 0.01, None), Err(FitError::Anisotropic)));
    let broken = Specular::Phong(Phong { exponent: f64::NAN });
    assert!(matches!(attempt(broken, Choice::Auto, 0.01, None), Err(FitError::Material(_))));
}

/// The choice and its reason are in the notes, the promise holds what was measured, progress ends at 1.
#[test]
fn tables_state_what_they_are() {
    let done = Mutex::new(Vec::new());
    let options = Options {
        representation: Choice::Auto,
        solver: SolverKind::LevenbergMarquardt,
        lobes: None,
        tolerance: 1e-5,
        seed: 9,
        command: "a command".into(),
        progress: &|x| {
            done.lock().unwrap().push(x);
            ControlFlow::Continue(())
        },
    };
    let table = super::fit(&Material::specular(Specular::Phong(Phong { exponent: 10.0 })), &options).unwrap();
    let h = &table.header;
    assert_eq!((h.seed, h.command.as_str(), table.representation_name()), (9, "a command", "zonal"));
    assert!(h.notes[0].starts_with("zonal: the lobe is radial"), "{:?}", h.notes);
    // Sixteen bits do not reach 1e-5.
    assert!(h.notes.iter().any(|n| n.contains("not reached")), "{:?}", h.notes);
    assert!(h.promise[2] >= f64::from(h.off_nodes.worst.rmse_lobe) && h.promise[2] < 0.01, "{:?}", h.promise);
    assert!(h.off_nodes.caps > 50 && h.clipped.caps > 50 && h.at_nodes.caps > 5);
    assert_eq!(table.cells.len(), table.axes.len());
    let done = done.into_inner().unwrap();
    assert!(done.iter().all(|x| (0.0..=1.0).contains(x)) && done.last() == Some(&1.0));
}
