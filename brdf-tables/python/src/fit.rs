//! `fit`: from a material to a table, with progress, in threads that the person can stop.

use crate::error::{self, bad};
use crate::material::Named;
use crate::table::Table;
use core::ops::ControlFlow;
use fitter::fit::{Choice, FitError, Options, TOLERANCE};
use fitter::solver::SolverKind;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// Time between two looks at what the interpreter wants.
const PAUSE: Duration = Duration::from_millis(50);

#[pyfunction]
#[pyo3(signature = (
    material, *, representation = None, solver = None, lobes = None, tolerance = TOLERANCE, seed = 1, threads = None,
    progress = None
))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn fit(
    py: Python<'_>,
    material: Named<'_>,
    representation: Option<&str>,
    solver: Option<&str>,
    lobes: Option<usize>,
    tolerance: f64,
    seed: u64,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Table> {
    let (material, name, notes) = material.load(py)?;
    let asked = representation.map(str::parse::<Choice>).transpose().map_err(bad)?;
    let chosen = solver.map(str::parse::<SolverKind>).transpose().map_err(bad)?;
    let option = chosen.map(|_| "solver").or(lobes.map(|_| "lobes"));
    let refuse = |error: FitError| error::fit(&name, &error);
    let representation = Choice::of(&material, asked, option).map_err(refuse)?;
    let (done, stop) = (AtomicU64::new(0), AtomicBool::new(false));
    let options = Options {
        representation,
        solver: chosen.unwrap_or(SolverKind::LevenbergMarquardt),
        lobes,
        tolerance,
        seed,
        command: command(&name, asked, chosen, lobes, tolerance, seed),
        progress: &|fraction| {
            // Fractions are not negative: their bits are in their order.
            done.fetch_max(fraction.to_bits(), Ordering::Relaxed);
            if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        },
    };
    let pool = match threads {
        None => None,
        Some(n @ 1..=1024) => Some(rayon::ThreadPoolBuilder::new().num_threads(n).build().map_err(bad)?),
        Some(n) => return Err(bad(format!("{n} threads: 1 to 1024 are possible"))),
    };
    let work = || match &pool {
        Some(pool) => pool.install(|| fitter::fit::fit(&material, &options)),
        None => fitter::fit::fit(&material, &options),
    };
    let fitted = py.detach(|| {
        std::thread::scope(|scope| {
            let (finished, fitting) = mpsc::channel();
            // Nobody listens any more only where the fit was told to stop.
            scope.spawn(move || drop(finished.send(work())));
            let mut told = -1.0;
            loop {
                let answer = fitting.recv_timeout(PAUSE);
                let fraction = f64::from_bits(done.load(Ordering::Relaxed));
                let tell = fraction > told && !stop.load(Ordering::Relaxed);
                told = fraction;
                let heard = Python::attach(|py| {
                    py.check_signals()?;
                    if let (true, Some(progress)) = (tell, &progress) {
                        progress.call1(py, (fraction,))?;
                    }
                    Ok(())
                });
                if let Err(exception) = heard {
                    // The scope waits for the threads, which stop at their next cell.
                    stop.store(true, Ordering::Relaxed);
                    return Err(exception);
                }
                match answer {
                    Ok(fitted) => return fitted.map_err(refuse),
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(bad(format!("{name}: the fit ended without a table")));
                    }
                }
            }
        })
    });
    let mut inner = fitted?;
    inner.header.notes.splice(0..0, notes);
    Ok(Table { inner })
}

/// The command line that makes the same table.
fn command(
    name: &str,
    asked: Option<Choice>,
    solver: Option<SolverKind>,
    lobes: Option<usize>,
    tolerance: f64,
    seed: u64,
) -> String {
    let mut words = vec![format!("brdf_tables.fit({name:?}")];
    words.extend(asked.map(|x| format!("representation=\"{x}\"")));
    words.extend(solver.map(|x| format!("solver=\"{x}\"")));
    words.extend(lobes.map(|x| format!("lobes={x}")));
    words.extend((tolerance != TOLERANCE).then(|| format!("tolerance={tolerance}")));
    words.push(format!("seed={seed})"));
    words.join(", ")
}
