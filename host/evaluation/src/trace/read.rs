//! Recordings from CSV files.
//!
//! Columns `time_s`, `encoder_counts`, `current_a`, `duty` where the current is unsigned or for the motor's voltage, `emf_v` in what the
//! firmware streamed; all others are ignored.
//! Lines that start with `#` are comments.

use std::fmt;
use std::io::Read;

use super::Row;

/// Times beyond this (a thousand years) are nonsense, and would lose their milliseconds.
const LARGEST_TIME_S: f64 = 3.2e10;
/// Counts beyond this lose single counts in f64.
const LARGEST_COUNTS: f64 = 9.0e15;
/// No motor of this size draws that much; a file in milliampere would.
const LARGEST_CURRENT_A: f64 = 1.0e3;
/// Nor is its back-EMF larger.
const LARGEST_VOLTAGE_V: f64 = 1.0e3;
/// Share of a full duty below which its sign says nothing.
const NO_DUTY: f64 = 1e-9;

/// Why a file cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub enum ReadError {
    /// A column is missing.
    MissingColumn(&'static str),
    /// A column is there twice.
    RepeatedColumn(&'static str),
    /// A field cannot be used.
    Field {
        /// Line of the file, the first is 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// What stands there.
        text: String,
        /// What was expected.
        expected: &'static str,
    },
    /// The line itself is malformed.
    Line {
        /// Line of the file, the first is 1.
        line: u64,
        /// What is wrong.
        what: String,
    },
    /// Fewer than two usable rows.
    Empty,
}

impl fmt::Display for ReadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MissingColumn(name) => write!(
                out,
                "line 1: no column '{name}'; needed are time_s, encoder_counts and current_a"
            ),
            Self::RepeatedColumn(name) => write!(out, "line 1: column '{name}' is there twice"),
            Self::Field {
                line,
                column,
                text,
                expected,
            } => write!(
                out,
                "line {line}, column {column}: '{text}' is not {expected}"
            ),
            Self::Line { line, what } => write!(out, "line {line}: {what}"),
            Self::Empty => write!(out, "fewer than two rows"),
        }
    }
}

impl std::error::Error for ReadError {}

/// What was odd about a file that could be used all the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    /// Rows read.
    pub rows: usize,
    /// Rows with the time of the row before; left out.
    pub repeated: usize,
    /// Rows with a time before that of an earlier row; left out.
    pub backward: usize,
    /// The current was unsigned and took its sign from the duty.
    pub sign_from_duty: bool,
}

/// Where the columns stand.
pub(super) struct Columns {
    pub(super) time: usize,
    pub(super) counts: usize,
    pub(super) current: usize,
    pub(super) duty: Option<usize>,
    pub(super) emf: Option<usize>,
}

pub(super) fn columns(header: &csv::StringRecord) -> Result<Columns, ReadError> {
    let find = |name: &'static str| {
        let mut at = header
            .iter()
            .enumerate()
            .filter(|(_, field)| field.trim_start_matches('\u{feff}').trim() == name)
            .map(|(index, _)| index);
        let first = at.next();
        match at.next() {
            Some(_) => Err(ReadError::RepeatedColumn(name)),
            None => Ok(first),
        }
    };
    let need = |name: &'static str| find(name)?.ok_or(ReadError::MissingColumn(name));
    Ok(Columns {
        time: need("time_s")?,
        counts: need("encoder_counts")?,
        current: need("current_a")?,
        duty: find("duty")?,
        emf: find("emf_v")?,
    })
}

/// A field as a finite number of at most `largest`.
pub(super) fn field(
    record: &csv::StringRecord,
    index: usize,
    column: &'static str,
    largest: f64,
    expected: &'static str,
) -> Result<f64, ReadError> {
    let text = record.get(index).unwrap_or("").trim();
    match text.parse::<f64>() {
        Ok(value) if value.abs() <= largest => Ok(value),
        _ => Err(ReadError::Field {
            line: record.position().map_or(0, csv::Position::line),
            column,
            text: text.chars().take(40).collect(),
            expected,
        }),
    }
}

/// The back-EMF of a row, volt; `None` where the cell is empty or there is no such column.
pub(super) fn back_emf(
    record: &csv::StringRecord,
    columns: &Columns,
) -> Result<Option<f64>, ReadError> {
    columns
        .emf
        .filter(|at| !record.get(*at).unwrap_or("").trim().is_empty())
        .map(|at| {
            field(
                record,
                at,
                "emf_v",
                LARGEST_VOLTAGE_V,
                "a voltage in volt below 1000",
            )
        })
        .transpose()
}

/// A reader that skips comments.
pub(super) fn reader<R: Read>(input: R) -> csv::Reader<R> {
    csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(input)
}

/// A line that is no CSV.
pub(super) fn malformed(error: csv::Error) -> ReadError {
    ReadError::Line {
        line: error.position().map_or(1, csv::Position::line),
        what: match error.kind() {
            csv::ErrorKind::Utf8 { .. } => "not UTF-8 text".to_owned(),
            csv::ErrorKind::Io(error) => error.to_string(),
            _ => error.to_string(),
        },
    }
}

/// Reads a recording. Rows out of order are left out and counted; anything unreadable is an error with its place.
///
/// # Errors
/// [`ReadError`], with line and column where there is one.
pub fn read(input: impl Read) -> Result<(Vec<Row>, Findings), ReadError> {
    let mut reader = reader(input);
    let columns = columns(&reader.headers().map_err(malformed)?.clone())?;
    let mut findings = Findings::default();
    let mut rows: Vec<Row> = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(malformed)? {
        let field =
            |index, column, largest, expected| field(&record, index, column, largest, expected);
        let row = Row {
            time_s: field(columns.time, "time_s", LARGEST_TIME_S, "a time in seconds")?,
            #[expect(clippy::cast_possible_truncation, reason = "bounded above")]
            encoder_counts: field(
                columns.counts,
                "encoder_counts",
                LARGEST_COUNTS,
                "a number of counts",
            )?
            .round() as i64,
            current_a: field(
                columns.current,
                "current_a",
                LARGEST_CURRENT_A,
                "a current in ampere below 1000",
            )?,
            duty: columns
                .duty
                .map(|index| field(index, "duty", f64::MAX, "a number"))
                .transpose()?,
            emf_v: back_emf(&record, &columns)?,
        };
        findings.rows += 1;
        match rows.last() {
            Some(last) if row.time_s == last.time_s => findings.repeated += 1,
            Some(last) if row.time_s < last.time_s => findings.backward += 1,
            _ => rows.push(row),
        }
    }
    if rows.len() < 2 {
        return Err(ReadError::Empty);
    }
    findings.sign_from_duty = sign_currents(&mut rows);
    Ok((rows, findings))
}

/// Gives an unsigned current the sign of the duty. A current is unsigned if it stays positive, noise aside, while the
/// bridge drives both ways.
fn sign_currents(rows: &mut [Row]) -> bool {
    let opening = |row: &Row| row.duty.is_some_and(|duty| duty < -NO_DUTY);
    let mean = |chosen: &dyn Fn(&Row) -> bool| {
        let (sum, count) = rows
            .iter()
            .filter(|row| chosen(row))
            .fold((0.0, 0.0), |(sum, count), row| {
                (sum + row.current_a, count + 1.0)
            });
        (count > 0.0).then(|| sum / count)
    };
    let unsigned = mean(&opening).is_some_and(|mean| mean > 0.0);
    if unsigned {
        for row in rows.iter_mut().filter(|row| opening(row)) {
            row.current_a = -row.current_a;
        }
    }
    unsigned
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn finds_its_columns_anywhere() {
        let file = "# made by hand\nduty,extra,current_a,time_s,encoder_counts\n0.5,x,0.02,0.0,10\n-0.5,,0.03,0.1,12\n";
        let (rows, findings) = read(file.as_bytes()).unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].encoder_counts, 10);
        assert!((rows[1].current_a + 0.03).abs() < 1e-12, "sign of the duty");
        assert!(findings.sign_from_duty);
    }

    #[test]
    fn signed_currents_stay() {
        let file = "time_s,encoder_counts,current_a,duty\n0,1,0.02,1\n1,2,-0.02,-1\n";
        let (rows, findings) = read(file.as_bytes()).unwrap();
        assert!((rows[1].current_a + 0.02).abs() < 1e-12);
        assert!(!findings.sign_from_duty);
    }

    #[test]
    fn disorder_is_counted_and_left_out() {
        let file = "time_s,encoder_counts,current_a\n0,1,0\n1,2,0\n1,2,0\n0.5,9,0\n2,3,0\n";
        let (rows, findings) = read(file.as_bytes()).unwrap();
        assert_eq!(rows.len(), 3);
        assert_eq!(
            (findings.rows, findings.repeated, findings.backward),
            (5, 1, 1)
        );
    }

    #[test]
    fn errors_name_their_place() {
        let text = |file: &str| read(file.as_bytes()).unwrap_err().to_string();
        assert_eq!(
            text("time_s,encoder_counts,current_a\n0,1,0\n1,two,0\n"),
            "line 3, column encoder_counts: 'two' is not a number of counts"
        );
        assert!(
            text("time_s,encoder_counts,current_a\n0,1,0\n1,2\n")
                .contains("line 3, column current_a: ''")
        );
        assert!(
            text("time_s,encoder_counts,current_a\n0,1,0\nNaN,2,0\n")
                .contains("line 3, column time_s")
        );
        assert!(text("time_s,counts\n0,1\n").contains("no column 'encoder_counts'"));
        assert!(text("time_s,time_s,encoder_counts,current_a\n").contains("twice"));
        assert!(text("").contains("line 1"));
        assert_eq!(
            text("time_s,encoder_counts,current_a\n0,1,0\n"),
            "fewer than two rows"
        );
    }

    proptest! {
        /// Rows in any order, now and then with a cell that is none.
        #[test]
        fn any_rows_are_put_in_order_or_refused(
            rows in proptest::collection::vec((0_u32..40, -9..9_i32, 0_u32..60), 0..40),
        ) {
            let mut file = String::from("time_s,encoder_counts,current_a,duty\n");
            let mut damaged = false;
            for (time_ms, counts, damage) in &rows {
                let current = if *damage == 0 { "x" } else { "0.02" };
                damaged |= *damage == 0;
                file.push_str(&format!("{},{counts},{current},1\n", f64::from(*time_ms) * 1e-3));
            }
            // A row counts if it is later than all before it.
            let mut latest = None;
            let mut later = 0;
            for (time_ms, ..) in &rows {
                if latest.is_none_or(|latest| *time_ms > latest) {
                    latest = Some(*time_ms);
                    later += 1;
                }
            }
            match read(file.as_bytes()) {
                Ok((read, findings)) => {
                    prop_assert!(!damaged && read.len() >= 2);
                    prop_assert_eq!(read.len(), later);
                    prop_assert!(read.windows(2).all(|pair| pair[0].time_s < pair[1].time_s));
                    prop_assert_eq!(read.len() + findings.repeated + findings.backward, findings.rows);
                }
                Err(error) => prop_assert!(damaged || later < 2, "{error:?}"),
            }
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
            let _ = read(bytes.as_slice());
        }

        #[test]
        fn any_table_is_read_or_refused(
            cells in proptest::collection::vec("[-+0-9eE.naif]{0,9}|\"", 0..60),
            width in 1_usize..5,
        ) {
            let mut file = String::from("time_s,encoder_counts,current_a,duty\n");
            for line in cells.chunks(width) {
                file.push_str(&line.join(","));
                file.push('\n');
            }
            if let Ok((rows, findings)) = read(file.as_bytes()) {
                prop_assert!(rows.len() >= 2);
                prop_assert!(rows.windows(2).all(|pair| pair[0].time_s < pair[1].time_s));
                prop_assert_eq!(rows.len() + findings.repeated + findings.backward, findings.rows);
            }
        }
    }
}
