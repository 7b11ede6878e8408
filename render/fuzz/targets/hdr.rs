//! Radiance HDR of any content: refused in one line, or a picture of finite colours.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|data: &[u8]| -> Corpus {
    if !data.starts_with(b"#?") {
        return Corpus::Reject;
    }
    render_fuzz::check_picture(data);
    Corpus::Keep
});
