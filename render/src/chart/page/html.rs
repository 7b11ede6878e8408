//! Pieces of HTML.

/// Text as HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A table; cells are HTML.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &mut dyn Iterator<Item = String>| format!("<tr>{}</tr>\n", cells.collect::<String>());
    let head = line(&mut head.iter().map(|h| format!("<th>{}</th>", escape(h))));
    let body: String = rows.iter().map(|r| line(&mut r.iter().map(|c| format!("<td>{c}</td>")))).collect();
    format!("<div class=\"wide\"><table>\n<thead>{head}</thead><tbody>\n{body}</tbody></table></div>\n")
}

/// A picture of a PNG in the page itself.
pub fn picture(png: &[u8], about: &str) -> String {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(png);
    format!("<img alt=\"{}\" src=\"data:image/png;base64,{data}\">", escape(about))
}

/// A whole page.
pub fn page(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         {body}</body>\n</html>\n"
    )
}

const STYLE: &str = "
body { font: 16px/1.5 Helvetica, Arial, sans-serif; color: #282c34; max-width: 1240px; margin: 2em auto; padding: 0 1.5em }
h1 { font-size: 1.7em } h2 { font-size: 1.35em; margin-top: 2em; border-bottom: 1px solid #d6dae0 } h3 { font-size: 1.1em }
p, li { max-width: 60em }
code { background: #f2f4f7; padding: .1em .3em; overflow-wrap: break-word }
dl { display: grid; grid-template-columns: max-content auto; gap: .2em 1.2em } dt { color: #667 } dd { margin: 0 }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr)); gap: 1.5em }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(190px, 1fr)); gap: 1em }
.small { grid-template-columns: repeat(auto-fill, minmax(150px, 1fr)) }
figure { margin: 0 } figcaption { font-size: .85em; color: #445 }
svg { max-width: 100%; height: auto; border: 1px solid #e6e9ee }
img { width: 100%; image-rendering: pixelated; display: block; margin-bottom: 3px }
.wide { overflow-x: auto }
table { border-collapse: collapse; font-size: .85em; margin: 1em 0; font-variant-numeric: tabular-nums }
th, td { padding: .25em .7em; text-align: right; border-bottom: 1px solid #e6e9ee; white-space: nowrap }
th:first-child, td:first-child { text-align: left } th { vertical-align: bottom }
.good { color: #00704d } .fair { color: #8a6100 } .fails { color: #b3261e; font-weight: bold }
.worst { background: #fdecea } .paper td { color: #667 }
.scale { height: 12px; max-width: 420px; background: linear-gradient(90deg, #0d084d, #1a66b3, #26b259, #f2d933, #cc1a1a) }
";
