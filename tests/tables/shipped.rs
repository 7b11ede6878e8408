//! The tables of the repository: made from the recipe beside them, and as good as they promise.

use brdf_tables::table::Table;
use fitter::check::check;
use fitter::recipe::material;
use std::path::Path;

#[test]
fn shipped_tables_keep_their_promise() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tables");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let recipe = entry.unwrap().path();
        if recipe.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        seen += 1;
        let table = Table::load(recipe.with_extension("tbl")).unwrap_or_else(|e| panic!("{}: {e}", recipe.display()));
        assert_eq!(table.header.material, material(recipe.to_str().unwrap()).unwrap(), "{}", recipe.display());
        let found = check(&table, 8, 5, &|_| ());
        assert!(found.passed, "{}: {:?} against {:?}", recipe.display(), found.main, found.promise);
    }
    assert!(seen >= 11, "only {seen} recipes");
}
