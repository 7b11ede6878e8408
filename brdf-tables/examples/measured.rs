//! f_r of a file of measured data, row by row: reads `wi_x wi_y wi_z wo_x wo_y wo_z` and writes `r g b` of f_r in sr⁻¹, as the
//! file has it and as a table keeps it. With `rgl` before the file, for files of RGL, reads `u v` besides and writes f_r cosθ of
//! the channels, the density, and for `u v` the sampled direction, value over density, density (zeros where there is none).
//!
//! cargo run --release -p brdf-tables --features measured --example measured -- gold.binary < directions.txt

use brdf_tables::measured::{load, rgl::Rgl};
use glam::{DVec2, DVec3};
use std::error::Error;
use std::io::{BufRead, Write, stdin, stdout};
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (file, raw) = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [file] => (file, None),
        ["rgl", file] => (file, Some(Rgl::read(&std::fs::read(file)?)?)),
        _ => return Err("usage: measured [rgl] FILE < directions".into()),
    };
    let kept = if raw.is_none() { Some(load(Path::new(file))?) } else { None };
    let mut out = stdout().lock();
    for line in stdin().lock().lines() {
        let numbers = line?.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let vector = |at: usize| numbers.get(at..at + 3).map(|v| DVec3::new(v[0], v[1], v[2]));
        let (wi, wo) = vector(0).zip(vector(3)).ok_or("six numbers are needed")?;
        if let Some((reading, built)) = &kept {
            let data = reading.source.rgb(wi, wo).unwrap_or([0.0; 3]);
            let [a, b, c] = built.material.eval(wi, wo);
            writeln!(out, "{} {} {} {a} {b} {c}", data[0], data[1], data[2])?;
        }
        if let Some(rgl) = &raw {
            let u = numbers.get(6..8).ok_or("eight numbers are needed")?;
            let (r, pdf) = (rgl.eval_cos(wi, wo), rgl.pdf(wi, wo));
            let (d, value, density) = rgl.sample(wo, DVec2::new(u[0], u[1])).unwrap_or_default();
            write!(out, "{} {} {} {pdf} {} {} {} ", r[0], r[1], r[2], d.x, d.y, d.z)?;
            writeln!(out, "{} {} {} {density}", value[0], value[1], value[2])?;
        }
    }
    Ok(())
}
