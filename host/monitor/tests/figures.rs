//! The manual's pictures of monitor and page, drawn from one stored grasp, and what a browser makes of the page.
//!
//! `PALPATE_WRITE_FIGURES=1 cargo test --profile host --package palpate-monitor --test figures` writes them; without the
//! variable they must be what would be written. The browser is Chromium; without it its test says so and passes.

mod browser;

use std::path::{Path, PathBuf};

use palpate::app::console::settings::Setting;
use palpate_monitor::command_line::CommandLine;
use palpate_monitor::page::GraspPage;
use palpate_monitor::screen::{Focus, View, draw};
use palpate_monitor::state::State;
use palpate_monitor::stream::{Level, Message, parse};
use palpate_monitor::{scenes, svg};
use ratatui::Terminal;
use ratatui::backend::TestBackend;

/// A grasp of the emulated firmware, as `cargo xtask sim --events FILE` leaves it, without answers `kept`; of the samples every tenth since
/// the last closing began.
const GRASP: &str = include_str!("data/grasp.jsonl");
const TITLE: &str = "A simulated grasp";
/// Widest difference of the brightness of two pictures of the same page, of 1: fonts differ.
const SAME: f64 = 0.03;

fn messages() -> impl Iterator<Item = Message> {
    GRASP.lines().filter_map(parse)
}

fn figures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/figures")
}

fn writes() -> bool {
    std::env::var_os("PALPATE_WRITE_FIGURES").is_some()
}

/// Compares with what stands in the manual, or puts it there.
fn stands(name: &str, drawn: &str) {
    let file = figures().join(name);
    if writes() {
        std::fs::write(&file, drawn).expect("the folder of figures");
    }
    let stands = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        stands == drawn,
        "{} is older than what draws it; PALPATE_WRITE_FIGURES=1 and this test write it",
        file.display()
    );
}

#[test]
fn the_manual_shows_the_monitor() {
    let mut state = State::default();
    for message in messages() {
        // The moment before the finger opens.
        if matches!(&message, Message::Event(event) if event.text() == "state name=open from=hold")
        {
            break;
        }
        state.take(message);
    }
    let view = View {
        level: Level::Info,
        filter: String::new(),
        back: 0,
        colour: true,
        help: false,
        recording: None,
        focus: Focus::Keys,
    };
    let mut finger = state.scene.as_deref().and_then(scenes::finger);
    let mut terminal = Terminal::new(TestBackend::new(100, 30)).expect("a screen in memory");
    terminal
        .draw(|frame| {
            let finger = finger.as_mut().map(|finger| &mut **finger as _);
            draw(frame, &state, &view, &CommandLine::default(), finger);
        })
        .expect("it is drawn");
    stands("monitor.svg", &svg::of(terminal.backend().buffer()));
}

fn page() -> String {
    let mut page = GraspPage::default();
    messages().for_each(|message| page.take(message));
    let finger = page.scene().and_then(scenes::finger);
    page.html(TITLE, finger)
}

/// The grasp is of firmware that has these settings with these ranges: one that lags behind must be recorded again.
#[test]
fn the_grasp_is_of_the_present_settings() {
    for setting in Setting::ALL {
        // The finger of the grasp states no weight.
        if matches!(setting, Setting::Mounting | Setting::Weight) {
            continue;
        }
        let (name, range) = (setting.name(), format!("({})", setting.range()));
        let answer = format!("\"answer {name} ");
        let told = GRASP.lines().find(|line| line.contains(&answer));
        assert!(
            told.is_some_and(|line| line.contains(&range)),
            "{name} {range}: {told:?}"
        );
    }
}

#[test]
fn the_manual_shows_the_page() {
    stands("page.html", &page());
}

/// It can be sent to somebody without a network: it names nothing that would have to be fetched, and forbids it.
#[test]
fn the_page_refers_to_nothing_outside() {
    let page = page().to_lowercase();
    for reference in [
        "://", "src=", "href=", "url(", "@import", "<link", "<script", "<iframe", "<object", "<img",
    ] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert!(page.contains("content=\"default-src 'none'; style-src 'unsafe-inline'\""));
}

#[test]
fn a_browser_shows_the_page_by_day_by_night_and_on_paper() {
    let file = std::env::temp_dir().join(format!("palpate-page-{}.html", std::process::id()));
    std::fs::write(&file, page()).expect("a temporary file");
    let Some(light) = browser::picture(&file, false) else {
        return;
    };
    let dark = browser::picture(&file, true).expect("as before");
    let paper = browser::paper(&file).expect("as before");
    std::fs::remove_file(&file).expect("the file is there");
    let (day, night) = (browser::brightness(&light), browser::brightness(&dark));
    println!("brightness {day:.3} by day, {night:.3} by night");
    assert!(day > 0.85, "dark ink on white: {day}");
    assert!(night < 0.25, "light ink on black: {night}");
    // Two pages, figures above and table below; none of them empty.
    let text = String::from_utf8_lossy(&paper);
    let pages = text.matches("/Type /Page\n").count() + text.matches("/Type /Page ").count();
    assert!(
        text.starts_with("%PDF") && (1..=3).contains(&pages),
        "{pages} pages"
    );

    let shown = figures().join("page.png");
    if writes() {
        std::fs::write(&shown, &light).expect("the folder of figures");
    }
    let stands = std::fs::read(&shown).expect("the manual's picture");
    let difference = (browser::brightness(&stands) - day).abs();
    assert!(
        difference < SAME,
        "the manual's picture is another one: {difference}"
    );
}
