//! PNG and JPEG of any content: refused in one line, or a picture of finite colours.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|data: &[u8]| -> Corpus {
    if !data.starts_with(b"\x89PNG") && !data.starts_with(b"\xff\xd8") {
        return Corpus::Reject;
    }
    render_fuzz::check_picture(data);
    Corpus::Keep
});
