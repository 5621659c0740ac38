//! Chromium without a window, and its pictures.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

const PROGRAMS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];
/// Pixels of a picture of a page.
const WINDOW: &str = "--window-size=1120,1500";

/// Opens a page with more options and returns the file that these name; none without a browser.
fn open(page: &Path, options: &[&str], result: &Path) -> Option<Vec<u8>> {
    let ran = PROGRAMS.iter().find_map(|program| {
        let mut call = Command::new(program);
        call.args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            WINDOW,
        ])
        .args(options)
        .arg(format!("file://{}", page.display()))
        .stderr(Stdio::null())
        .stdout(Stdio::null());
        call.status().ok()
    });
    let Some(status) = ran else {
        eprintln!("no browser is on the path: apt-get install chromium");
        return None;
    };
    assert!(status.success(), "the browser fails: {status}");
    let bytes = std::fs::read(result).expect("the browser writes a file");
    std::fs::remove_file(result).expect("the file is there");
    Some(bytes)
}

fn beside(page: &Path, ending: &str) -> std::path::PathBuf {
    page.with_extension(ending)
}

/// A page as PNG, for a reader who likes it dark or not.
pub fn picture(page: &Path, dark: bool) -> Option<Vec<u8>> {
    let result = beside(page, "png");
    let shot = format!("--screenshot={}", result.display());
    // The scheme that the reader prefers: 0 dark, 1 light.
    let scheme = format!("--blink-settings=preferredColorScheme={}", u8::from(!dark));
    open(page, &[&shot, &scheme], &result)
}

/// A page as PDF.
pub fn paper(page: &Path) -> Option<Vec<u8>> {
    let result = beside(page, "pdf");
    let print = format!("--print-to-pdf={}", result.display());
    open(page, &[&print, "--no-pdf-header-footer"], &result)
}

/// Mean brightness of a PNG of eight bits without palette or interlacing, 0 to 1; transparency counts as it is painted.
pub fn brightness(png: &[u8]) -> f64 {
    let number = |at: usize| {
        let bytes: [u8; 4] = png[at..at + 4].try_into().expect("four bytes");
        u32::from_be_bytes(bytes) as usize
    };
    let (width, height) = (number(16), number(20));
    let channels = match png[25] {
        2 => 3,
        6 => 4,
        other => panic!("colour type {other}"),
    };
    let mut packed = Vec::new();
    let mut at = 8;
    while at + 8 <= png.len() {
        let length = number(at);
        if &png[at + 4..at + 8] == b"IDAT" {
            packed.extend_from_slice(&png[at + 8..at + 8 + length]);
        }
        at += 12 + length;
    }
    let mut rows = Vec::new();
    let mut unpacked = flate2::read::ZlibDecoder::new(packed.as_slice());
    unpacked.read_to_end(&mut rows).expect("a whole picture");
    let stride = width * channels;
    let mut above = vec![0_u8; stride];
    let mut sum = 0.0;
    for row in rows.chunks_exact(stride + 1).take(height) {
        let mut line = vec![0_u8; stride];
        for index in 0..stride {
            let left = index.checked_sub(channels).map_or(0, |at| line[at]);
            let corner = index.checked_sub(channels).map_or(0, |at| above[at]);
            let guess = match row[0] {
                1 => left,
                2 => above[index],
                3 => ((u16::from(left) + u16::from(above[index])) / 2) as u8,
                4 => paeth(left, above[index], corner),
                _ => 0,
            };
            line[index] = row[index + 1].wrapping_add(guess);
        }
        for pixel in line.chunks_exact(channels) {
            sum += pixel
                .iter()
                .take(3)
                .map(|&part| f64::from(part))
                .sum::<f64>()
                / (3.0 * 255.0);
        }
        above = line;
    }
    sum / (width * height) as f64
}

/// The neighbour that is nearest to left + above - corner.
fn paeth(left: u8, above: u8, corner: u8) -> u8 {
    let [a, b, c] = [left, above, corner].map(i32::from);
    let distance = |x: i32| (a + b - c - x).abs();
    if distance(a) <= distance(b) && distance(a) <= distance(c) {
        left
    } else if distance(b) <= distance(c) {
        above
    } else {
        corner
    }
}
