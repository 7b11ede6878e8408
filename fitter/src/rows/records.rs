//! Records of CSV, as far as they have arrived.

use anyhow::{Context, bail};
use csv_core::ReadRecordResult;
use std::io::{BufRead, BufReader, Chain, Cursor, Read};

/// Longest record, bytes.
const MAX_RECORD: usize = 4096;
/// Most columns.
const MAX_COLUMNS: usize = 64;

/// The fields of a record, and the line on which it begins.
pub(super) struct Record {
    pub line: u64,
    pub fields: Vec<String>,
}

/// What comes next.
pub(super) enum Next {
    /// A record.
    Record(Record),
    /// More input has to come first.
    Waiting,
    /// Nothing more.
    End,
}

/// Records of bounded length; lines end with LF, CRLF or CR, and those without content are skipped.
pub(super) struct Records<R> {
    reader: BufReader<Chain<Cursor<Vec<u8>>, R>>,
    parser: csv_core::Reader,
    bytes: [u8; MAX_RECORD],
    /// Bytes that the current record has so far.
    used: usize,
    ends: [usize; MAX_COLUMNS],
    fields: usize,
    begun: bool,
    /// Line on which it begins.
    line: u64,
    /// Ends of lines so far.
    lines: u64,
    after_cr: bool,
}

impl<R: Read> Records<R> {
    /// Skips byte order marks.
    pub fn new(mut input: R) -> anyhow::Result<Self> {
        const MARK: [u8; 3] = [0xef, 0xbb, 0xbf];
        let mut start = Vec::new();
        // All of them: the parser takes one that arrives alone for the end of the input.
        loop {
            input.by_ref().take(MARK.len() as u64).read_to_end(&mut start).context("standard input")?;
            if start != MARK {
                break;
            }
            start.clear();
        }
        Ok(Self {
            reader: BufReader::with_capacity(1 << 16, Cursor::new(start).chain(input)),
            parser: csv_core::Reader::new(),
            bytes: [0; MAX_RECORD],
            used: 0,
            ends: [0; MAX_COLUMNS],
            fields: 0,
            begun: false,
            line: 1,
            lines: 0,
            after_cr: false,
        })
    }

    /// The next record; without `wait` only one that is there already.
    pub fn next(&mut self, wait: bool) -> anyhow::Result<Next> {
        loop {
            if !wait && self.reader.buffer().is_empty() {
                return Ok(Next::Waiting);
            }
            let input = self.reader.fill_buf().context("standard input")?;
            let (result, read, bytes, fields) =
                self.parser.read_record(input, &mut self.bytes[self.used..], &mut self.ends[self.fields..]);
            for &byte in &input[..read] {
                let ends = byte == b'\r' || byte == b'\n' && !self.after_cr;
                self.after_cr = byte == b'\r';
                self.lines += u64::from(ends);
                if !self.begun {
                    self.begun = byte != b'\r' && byte != b'\n';
                    self.line = self.lines + 1;
                }
            }
            self.reader.consume(read);
            self.used += bytes;
            self.fields += fields;
            let place = || format!("standard input, line {}", self.line);
            match result {
                ReadRecordResult::InputEmpty => {}
                ReadRecordResult::OutputFull => bail!("{}: longer than {MAX_RECORD} bytes", place()),
                ReadRecordResult::OutputEndsFull => bail!("{}: more than {MAX_COLUMNS} columns", place()),
                ReadRecordResult::End => return Ok(Next::End),
                ReadRecordResult::Record => {
                    let mut start = 0;
                    let fields = self.ends[..self.fields].iter().map(|&end| {
                        let field = std::str::from_utf8(&self.bytes[start..end]).map(str::to_owned);
                        start = end;
                        field.ok().with_context(|| format!("{}: not UTF-8 text", place()))
                    });
                    let record = Record { line: self.line, fields: fields.collect::<anyhow::Result<_>>()? };
                    (self.used, self.fields, self.begun) = (0, 0, false);
                    // What a spreadsheet leaves of rows that were cleared.
                    if record.fields.iter().any(|field| !field.trim().is_empty()) {
                        return Ok(Next::Record(record));
                    }
                }
            }
        }
    }
}
