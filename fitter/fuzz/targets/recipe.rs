//! A recipe of any bytes, as a file and as an argument: refused in one line, or a material whose values are finite and
//! not negative, and whose own recipe says the same again.
#![no_main]

use brdf_tables::frame::spherical;
use brdf_tables::material::Material;
use fitter::recipe::{RecipeError, from_bytes, material as material_of};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    judge(from_bytes("a.toml", data));
    // Without these it cannot be the name of a file.
    if let Ok(text) = std::str::from_utf8(data)
        && text.contains([':', '='])
        && !text.ends_with(".toml")
    {
        judge(material_of(text));
    }
});

fn judge(read: Result<Material, RecipeError>) {
    let material = match read {
        Ok(material) => material,
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains(['\n', '\r']), "{line:?}");
            return;
        }
    };
    material.validate().expect("a material that was read is valid");
    for (to, from) in [((0.0, 0.0), (0.0, 0.0)), ((0.7, 1.0), (0.7, 4.14)), ((1.5, 2.0), (0.2, 5.0))] {
        let values = material.eval(spherical(to.0, to.1), spherical(from.0, from.1));
        assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "{values:?} of {material:?}");
    }
    let text = material.recipe_text();
    assert_eq!(material_of(&text).expect(&text), material);
}
