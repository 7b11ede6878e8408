//! `render chart`: a sweep, its files, going on after an interruption, the suite, and one line for every mistake.

mod support;

use std::path::{Path, PathBuf};
use support::Folder;

/// A glossy floor under a lamp beside a wall.
const SCENE: &str = r#"<scene version="3.0.0">
    <default name="ks" value="0.6"/>
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 1.2, 4" target="0, 0.4, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/><rfilter type="box"/></film>
    </sensor>
    <bsdf type="twosided" id="glossy"><bsdf type="phong">
        <rgb name="diffuse_reflectance" value="0.2"/><rgb name="specular_reflectance" value="$ks"/>
        <float name="exponent" value="20"/>
    </bsdf></bsdf>
    <bsdf type="twosided" id="wall"><bsdf type="diffuse"><rgb name="reflectance" value="0.6"/></bsdf></bsdf>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform><ref id="glossy"/>
    </shape>
    <shape type="rectangle"><transform name="to_world"><scale value="2"/><translate z="-1"/></transform><ref id="wall"/></shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="90"/><scale value="0.4"/><translate y="2"/></transform>
        <emitter type="area"><rgb name="radiance" value="8"/></emitter>
    </shape>
</scene>"#;

/// Charts in a folder of its own.
struct Charts(Folder);

impl Charts {
    /// With the project's tables: those of the scene are shipped, nothing is fitted.
    fn new() -> Self {
        let tables = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tables");
        Self(Folder::with(SCENE, &["chart", "--tables", &tables.display().to_string()]))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path(name)
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Runs; returns what was said of each cell that was run.
    fn ok(&self, args: &str) -> Vec<String> {
        let (_, err) = self.0.ok(args);
        err.lines().filter(|l| l.contains("rel_mse")).map(str::to_owned).collect()
    }

    fn bad(&self, args: &str, mention: &str) {
        self.0.bad(args, mention);
    }
}

/// Columns of a CSV, by name.
fn column(text: &str, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let i = reader.headers().unwrap().iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}"));
    reader.records().map(|r| r.unwrap()[i].to_owned()).collect()
}

fn numbers(text: &str, name: &str) -> Vec<f64> {
    column(text, name).iter().map(|x| x.parse().unwrap()).collect()
}

/// Nothing outside of the page is needed: whatever it loads or links to is inside.
fn assert_self_contained(page: &str) {
    for attribute in ["src=\"", "href=\"", "url("] {
        for (i, _) in page.match_indices(attribute) {
            let value = &page[i + attribute.len()..];
            assert!(value.starts_with("data:") || value.starts_with('#'), "{attribute}{:.60}", value);
        }
    }
    assert!(!page.contains("<script") && !page.contains("<link") && !page.contains("@import"));
    // The letters of embedded pictures may spell anything.
    let (first, others) = page.split_once(";base64,").unwrap_or((page, ""));
    let after_pictures = others.split(";base64,").map(|part| part.split_once('"').map_or("", |(_, rest)| rest));
    let written: String = std::iter::once(first).chain(after_pictures).collect();
    assert!(!written.contains("NaN") && !written.contains("inf "));
}

const SWEEP: &str = "scene.xml --methods path,eas --times 0.05,0.1 --taus 0.2 --sources 10 --spp 4 \
                     --reference-time 0.5 -o out";

#[test]
fn a_sweep_is_written_and_goes_on_where_it_stopped() {
    let f = Charts::new();
    let said = f.ok(SWEEP);
    assert_eq!(said.len(), 6, "{said:?}");
    let table = f.text("out/chart.csv");
    assert_eq!(column(&table, "method"), ["path", "path", "eas", "eas", "eas", "eas"]);
    assert_eq!(
        column(&table, "setting"),
        ["time=0.05", "time=0.1", "time=0.05", "time=0.1", "tau=0.2", "sources=10,tau=0.2"]
    );
    assert_eq!(numbers(&table, "size")[5], 10.0);
    assert!(numbers(&table, "rel_mse").iter().all(|e| *e > 0.0 && *e < 1.0), "{table}");
    for (name, row) in [("records", 4), ("glossy_records", 4), ("size", 4), ("bytes_per_record", 4), ("fill", 4)] {
        assert!(numbers(&table, name)[row] > 0.0 && numbers(&table, name)[0] == 0.0, "{name}: {table}");
    }
    for figure in ["error-time", "error-bytes", "error-size", "records-time"] {
        let svg = f.text(&format!("out/figures/scene-{figure}.svg"));
        assert!(svg.starts_with("<svg") && svg.contains("eas") && !svg.contains("NaN"), "{figure}");
    }
    assert_eq!(std::fs::read_dir(f.path("out/pictures")).unwrap().count(), 2 * 6 + 1);
    assert_eq!(std::fs::read_dir(f.path("out/references")).unwrap().count(), 1);
    let page = f.text("out/index.html");
    assert_self_contained(&page);
    for words in ["render chart", "Which method wins", "At 0.1 s", "<svg", "data:image/png;base64,", "tau=0.2", "seed"]
    {
        assert!(page.contains(words), "{words}");
    }

    // The same again runs nothing and changes nothing.
    assert!(f.ok(SWEEP).is_empty());
    assert_eq!((f.text("out/chart.csv"), f.text("out/index.html")), (table.clone(), page));
    // What an interruption left out is run, and no more.
    let lines: Vec<&str> = table.lines().collect();
    std::fs::write(f.path("out/chart.csv"), lines[..4].join("\n") + "\n").unwrap();
    let said = f.ok(SWEEP);
    assert!(said.len() == 3 && said[0].contains("eas time=0.1") && said[1].contains("eas tau=0.2"), "{said:?}");
    assert_eq!(column(&f.text("out/chart.csv"), "setting"), column(&table, "setting"));
    // A new setting is run beside the old ones; another scene is another table.
    let said = f.ok(&SWEEP.replace("--taus 0.2", "--taus 0.2,0.3"));
    assert!(said.len() == 1 && said[0].contains("tau=0.3"), "{said:?}");
    let said = f.ok(&(SWEEP.to_owned() + " -D ks=0.3"));
    assert_eq!(said.len(), 6, "{said:?}");
    assert_eq!(column(&f.text("out/chart.csv"), "scene").len(), 7 + 6);
    // Without time budgets the same seed gives the same errors.
    let taus = "scene.xml --methods eas,irradiance --times 0.05 --taus 0.2 --sources 10 --spp 4";
    f.ok(&format!("{taus} --threads 1 --reference-time 0.5 -o one"));
    f.ok(&format!("{taus} --threads 2 --reference {} -o two", reference(&f, "one")));
    let errors = |folder: &str| {
        let table = f.text(&format!("{folder}/chart.csv"));
        let all = numbers(&table, "rmse").into_iter().zip(column(&table, "setting"));
        all.filter(|r| r.1 == "tau=0.2").map(|r| r.0).collect::<Vec<_>>()
    };
    assert_eq!((errors("one"), errors("one").len()), (errors("two"), 2));
}

/// The reference that a chart kept.
fn reference(f: &Charts, folder: &str) -> String {
    let mut entries = std::fs::read_dir(f.path(folder).join("references")).unwrap();
    entries.next().unwrap().unwrap().path().display().to_string()
}

/// Records of one size, whatever the view needs, for harmonics too.
#[test]
fn sizes_are_swept() {
    let f = Charts::new();
    f.ok("scene.xml --methods sh,sh-29,eas-paper --times 0.05 --taus 0.3 --orders 3,6 --sources 10 --spp 4 \
          --reference-time 0.5 -o out");
    let table = f.text("out/chart.csv");
    let (settings, sizes) = (column(&table, "setting"), numbers(&table, "size"));
    let found: Vec<_> = settings.iter().zip(sizes).filter(|r| r.0.contains(',')).collect();
    let wanted = [("order=3,tau=0.3", 3.0), ("order=6,tau=0.3", 6.0), ("sources=10,tau=0.3", 10.0)];
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for ((setting, size), wanted) in found.iter().zip(wanted) {
        assert_eq!((setting.as_str(), *size), wanted);
    }
    // The orders that directions take when none is given, as published.
    let page = f.text("out/index.html");
    assert!(page.contains("id=\"orders\"") && page.contains("<figcaption>phong:exponent=15"));
    assert_self_contained(&page);
    assert!(f.text("out/figures/order-ward-0.6-0.25.svg").starts_with("<svg"));
}

/// Every method has a twin whose pictures are denoised, in the same time.
#[test]
fn denoised_twins_are_charted() {
    let f = Charts::new();
    let twins = "scene.xml --methods path,path-denoised,eas-denoised --denoise builtin --times 0.3 --taus 0.2 --reference-time 0.5 -o out";
    assert_eq!(f.ok(twins).len(), 3);
    let table = f.text("out/chart.csv");
    assert_eq!(column(&table, "method"), ["path", "path-denoised", "eas-denoised"]);
    let (denoise, errors, seconds) =
        (numbers(&table, "denoise"), numbers(&table, "rel_mse"), numbers(&table, "seconds"));
    assert!(denoise[0] == 0.0 && denoise[1] > 0.0 && denoise[2] > 0.0, "{table}");
    assert!(errors.iter().chain(&seconds).all(|x| *x > 0.0 && *x < 1.0), "{table}");
    let page = f.text("out/index.html");
    assert!(page.contains("path-denoised") && page.contains("<h3>Crops</h3>"));
    assert_self_contained(&page);
    f.bad("scene.xml --methods path-denoised --denoise off --times 0.1 -o no", "path-denoised is denoised");
    f.bad("scene.xml --methods path --denoise builtin --times 0.1 -o no", "end in -denoised");
}

#[test]
fn rows_of_peers_are_shown() {
    let f = Charts::new();
    f.ok(SWEEP);
    let table = f.text("out/chart.csv");
    let row = table.lines().nth(1).unwrap().replace(",path,time=0.05,", ",peer-denoised,spp=16,");
    std::fs::write(f.path("out/chart.csv"), format!("{table}{row}\n")).unwrap();
    assert!(f.ok(SWEEP).is_empty());
    let page = f.text("out/index.html");
    assert!(
        page.contains("<dt>peer-denoised</dt><dd>a peer") && page.contains("<td>peer-denoised</td><td>spp=16</td>")
    );
    assert!(f.text("out/figures/scene-error-time.svg").contains("peer-denoised"));
    assert!(f.text("out/chart.csv").contains("peer-denoised"));

    // Rows of harmonics bring Table 1: here they are those of EAS under another name, so that all ratios are 1.
    assert!(!page.contains("id=\"table1\""));
    let table = f.text("out/chart.csv");
    let row = table.lines().find(|l| l.contains(",eas,tau=0.2,")).unwrap().replace(",eas,", ",sh,");
    std::fs::write(f.path("out/chart.csv"), format!("{table}{row}\n")).unwrap();
    f.ok(SWEEP);
    let page = f.text("out/index.html");
    for words in ["id=\"table1\"", "EAS, equal error", "RC, equal memory", "Matpreview", "their RMSE is"] {
        assert!(page.contains(words), "{words}");
    }
}

#[test]
fn the_suite_judges_every_method_and_scene() {
    let f = Charts::new();
    std::fs::create_dir(f.path("failure")).unwrap();
    std::fs::write(f.path("failure/a.xml"), SCENE).unwrap();
    std::fs::write(f.path("failure/dark.xml"), SCENE.replace("value=\"8\"", "value=\"0\"")).unwrap();
    let said = f.ok("--suite stability failure --width 16 --spp 4 --taus 0.2 --reference-time 0.5 -o out");
    let page = f.text("out/index.html");
    assert_self_contained(&page);
    for words in
        ["Stability", "ringing", "verdict", "Ours is the worst in", "<b>a</b>", "<b>dark</b>", "class=\"good\""]
    {
        assert!(page.contains(words), "{words}");
    }
    let table = f.text("out/chart.csv");
    let methods = column(&table, "method");
    assert_eq!(methods.len(), said.len());
    assert!(methods.len() >= 10 && methods.iter().any(|m| m == "auto"), "{methods:?}");
    assert_eq!(numbers(&table, "width"), vec![16.0; methods.len()]);
    // A black picture has no error under any method.
    let scenes = column(&table, "scene");
    let errors = numbers(&table, "rel_mse");
    assert!(scenes.iter().zip(&errors).all(|(s, e)| s != "dark" || *e == 0.0), "{table}");
}

#[test]
fn mistakes_are_named() {
    // Path tracing needs no tables.
    let f = Charts(Folder::with(SCENE, &["chart"]));
    let of = |more: &str| format!("scene.xml --methods path --times 0.05 {more}");
    let with = |more: &str| of(&format!("--reference-time 0.5 {more}"));
    f.bad(&with("-o out missing.xml"), "missing.xml");
    f.bad("-o out", "SCENE");
    f.bad("--suite stability -o out", "tests/scenes/failure: there is no such folder");
    f.bad("scene.xml scene.xml -o out", "scene: two scenes of this name");
    f.bad(&of("--reference a.exr --reference b.exr -o out"), "--reference: 2 given for 1 scenes");
    f.bad(&of("--reference a.exr -o out"), "a.exr");
    f.bad("scene.xml --methods photons -o out", "photons");
    f.bad("scene.xml --methods path,path -o out", "path is there twice");
    f.bad("scene.xml --times 0 -o out", "--times");
    f.bad("scene.xml --times nan -o out", "--times");
    f.bad("scene.xml --taus 7 -o out", "--taus");
    f.bad("scene.xml --reference-error=-1 -o out", "--reference-error");
    f.bad("scene.xml --suite stability --taus 0.1,0.2 -o out", "one quality");
    assert!(!f.path("out/chart.csv").exists());
    std::fs::write(f.path("file"), "x").unwrap();
    f.bad(&with("-o file"), "file");
    f.ok(&with("-o out"));
    f.bad(
        &of(&format!("--width 16 --reference {} -o other", reference(&f, "out"))),
        "32×32 pixels, but scene has 16×16",
    );

    // Whatever is not a table of a chart is refused with its place, and left alone.
    let table = f.text("out/chart.csv");
    let (header, row) = table.split_once('\n').unwrap();
    let row = row.trim_end();
    let second = |from: &str, to: &str| format!("{header}\n{}\n", row.replacen(from, to, 1));
    let field = |i: usize, to: &str| {
        let mut fields: Vec<&str> = row.split(',').collect();
        fields[i] = to;
        format!("{header}\n{}\n", fields.join(","))
    };
    for (content, mention) in [
        (String::new(), "chart.csv:1"),
        ("a,b\n1,2\n".into(), "chart.csv:1"),
        ("\0\u{1}\u{2}".into(), "chart.csv:1"),
        (format!("{header}\n{row},7\n"), "line: 2"),
        (format!("{header}\n{row}\n{row}\n"), "chart.csv:3: the same cell"),
        (field(10, "fast"), "chart.csv:2: seconds"),
        (field(10, "NaN"), "chart.csv:2: seconds"),
        (field(10, "-1"), "chart.csv:2: seconds"),
        (field(18, "1e999"), "chart.csv:2: rel_mse"),
        (field(4, "-1"), "chart.csv:2: seed"),
        (field(1, "xyz"), "chart.csv:2: digest"),
        (second("path", "<script>"), "chart.csv:2: method"),
        (second("scene", "../scene"), "chart.csv:2: scene"),
    ] {
        std::fs::write(f.path("out/chart.csv"), &content).unwrap();
        f.bad(&with("-o out"), mention);
        assert_eq!(f.text("out/chart.csv"), content);
    }
    std::fs::write(f.path("out/chart.csv"), [0xff, 0xfe, 0x00]).unwrap();
    f.bad(&with("-o out"), "chart.csv");
}
