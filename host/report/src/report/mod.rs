//! `report`: speed against error of every candidate method, on the emulated core.
//!
//! Costs come from a run of the bench image on the emulated chip (`palpate-emulator bench`): its own cycle counter, which
//! counts executed instructions there, less an empty call; and the cycle bracket of its functions: below the core's table at
//! zero wait states, above it the longest branches and 4 cycles a flash line of 8 bytes, a taken branch and a literal on top,
//! for code that does not run from CCM SRAM. Errors are measured
//! here with the same code over all reference rows. The results of the timed rows must be the same bits on both.

mod check;
mod delay;
mod delay_table;
mod inputs;
mod judge;
mod measured;
mod plot;
mod published;
mod row;
mod summary;
mod table;
mod target;
mod whole;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use palpate_bench::candidate::Role;

use crate::size;
use palpate_image::Image;
use row::{OnChip, Row};
use target::Target;
use whole::Grasp;

/// What a reader of the page must know.
const INTRODUCTION: &str = include_str!("intro.md");

/// What follows `report`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench image.
    #[arg(long)]
    bench: PathBuf,
    /// What the emulator counted while it ran.
    #[arg(long)]
    counts: PathBuf,
    /// What the emulator counted during a grasp of the default scene.
    #[arg(long)]
    grasp: Option<PathBuf>,
    /// What it counted during other ones, each with words for it: where the longest update of the sensing is looked for.
    #[arg(long, value_name = "WORDS=FILE")]
    other_grasp: Vec<String>,
    /// Firmware images of the scenes, NAME=ELF, the default one first.
    #[arg(long, value_name = "NAME=ELF")]
    image: Vec<String>,
    /// Compiler that built the images.
    #[arg(long)]
    compiler: String,
    /// Recorded instruction counts.
    #[arg(long)]
    recorded: PathBuf,
    /// One JSON object a line instead of tables.
    #[arg(long)]
    json: bool,
    /// Fail where a chosen method is beaten, or instruction counts have grown.
    #[arg(long)]
    check: bool,
    /// Record this run's instruction counts for the compiler.
    #[arg(long)]
    record: bool,
    /// Measure delay against error by the settings, simulated: a minute on two processors.
    #[arg(long)]
    delays: bool,
    /// Write the short tables between the markers of this file.
    #[arg(long, value_name = "FILE")]
    results: Option<PathBuf>,
    /// Folder for the plots and the tables.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Joins errors and costs.
fn join(arguments: &Arguments) -> Result<Vec<Row>> {
    let image = Image::open(&arguments.bench)?;
    let measured = measured::read(&arguments.counts, &image)?;
    judge::judge()
        .into_iter()
        .map(|judged| {
            let on_chip = judged
                .checksum
                .map(|checksum| {
                    let one = measured
                        .iter()
                        .find(|one| one.task == judged.task && one.name == judged.name)
                        .with_context(|| {
                            format!("the chip did not run {} {}", judged.task, judged.name)
                        })?;
                    let reached = image.used_from(one.address);
                    anyhow::Ok(OnChip {
                        cost: one.cost,
                        flash_bytes: reached.iter().map(|symbol| u64::from(symbol.size)).sum(),
                        same_bits: checksum == one.checksum,
                    })
                })
                .transpose()?;
            Ok(Row {
                kind: "candidate",
                task: judged.task.to_owned(),
                name: judged.name.to_owned(),
                error: judged.error,
                on_chip,
                chosen: matches!(judged.role, Role::Used(_)),
                check: matches!(judged.role, Role::Check(_)),
                why: match judged.role {
                    Role::Used(why) | Role::Check(why) => Some(why),
                    Role::Rival => None,
                },
            })
        })
        .collect()
}

fn tasks(rows: &[Row]) -> Vec<&[Row]> {
    rows.chunk_by(|a, b| a.task == b.task).collect()
}

/// Everything that the report knows.
struct Report {
    rows: Vec<Row>,
    grasp: Option<Grasp>,
    sizes: Vec<size::Row>,
    delays: Vec<delay::Row>,
}

impl Report {
    fn gather(arguments: &Arguments) -> Result<Self> {
        let progress = palpate_cli::progress::spinner();
        progress.set_message("errors of every candidate");
        let rows = join(arguments)?;
        let mut grasp = arguments.grasp.as_deref().map(whole::read).transpose()?;
        for other in &arguments.other_grasp {
            if let Some(grasp) = &mut grasp {
                grasp.add(other)?;
            }
        }
        let sizes = size::rows(&arguments.image)?;
        progress.set_message("delays");
        let delays = if arguments.delays {
            delay::rows()?
        } else {
            Vec::new()
        };
        progress.finish_and_clear();
        Ok(Self {
            rows,
            grasp,
            sizes,
            delays,
        })
    }

    fn targets(&self) -> Vec<Target> {
        target::targets(&self.rows, self.grasp.as_ref(), &self.sizes)
    }

    /// The whole text of the tables.
    fn text(&self, compiler: &str, with_plots: bool) -> String {
        let mut text = format!(
            "Instructions are counted exactly on an emulated Cortex-M4F, not on silicon; cycles are a bracket computed from\n\
             them. {compiler}. Chosen methods in bold.\n"
        );
        text += &format!("\n## Targets\n\n{}", target::table(&self.targets()));
        for rows in tasks(&self.rows) {
            let name = rows.first().map_or("", |row| &row.task);
            let plot = if with_plots {
                format!("![error against cost]({name}.svg)\n\n")
            } else {
                String::new()
            };
            text += &format!("\n## {name}\n\n{plot}{}", table::task(rows));
        }
        text += &format!(
            "\n## What the firmware uses\n\n{}",
            table::choices(&self.rows)
        );
        if let Some(grasp) = &self.grasp {
            text += &format!("\n## Whole path\n\n{}", grasp.text());
            if let Some(row) = self.sizes.first() {
                text += &format!(
                    "\nOf {} bytes of RAM: {} in statics, {} in what lies in CCM SRAM, {} in the deepest stacks of this grasp, {} \
                     free.\n",
                    size::RAM_BYTES,
                    row.ram_bytes(),
                    row.ccm_bytes(),
                    grasp.stack_bytes(),
                    row.left().saturating_sub(grasp.stack_bytes()),
                );
            }
        }
        if !self.delays.is_empty() {
            let plot = if with_plots {
                "![error against delay](delay.svg)\n\n"
            } else {
                ""
            };
            text += &format!(
                "\n## Time from first contact against error\n\n{plot}{}",
                delay_table::table(&self.delays)
            );
        }
        if !self.sizes.is_empty() {
            text += &format!(
                "\n## Flash and RAM by scene\n\n{}",
                size::table(&self.sizes)
            );
        }
        text
    }

    fn print_json(&self) -> Result<()> {
        for row in &self.rows {
            println!("{}", serde_json::to_string(row)?);
        }
        if let Some(grasp) = &self.grasp {
            for figure in grasp.figures() {
                println!("{}", serde_json::to_string(&figure)?);
            }
            for stack in &grasp.stacks {
                println!(
                    "{}",
                    serde_json::json!({
                        "type": "stack", "name": stack.name, "used_bytes": stack.used_bytes,
                        "size_bytes": stack.size_bytes,
                    })
                );
            }
        }
        for size in &self.sizes {
            println!("{}", size.json());
        }
        for delay in &self.delays {
            println!("{}", serde_json::to_string(delay)?);
        }
        for target in self.targets() {
            println!("{}", serde_json::to_string(&target)?);
        }
        Ok(())
    }

    /// Plots, and the report as a page that shows them.
    fn write(&self, folder: &Path, compiler: &str) -> Result<()> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        for rows in tasks(&self.rows) {
            if let Some(first) = rows.first() {
                plot::task(folder, &first.task, rows)?;
            }
        }
        if !self.delays.is_empty() {
            plot::delays(folder, &self.delays)?;
        }
        let page = folder.join("README.md");
        let text = format!("{INTRODUCTION}{}", self.text(compiler, true));
        std::fs::write(&page, text).with_context(|| format!("cannot write {}", page.display()))
    }

    /// Prints what is wrong; whether nothing is.
    fn check(&self, recorded: &Path, compiler: &str) -> Result<bool> {
        let recorded = check::read(recorded)?;
        let (mut wrong, notes) = check::check(&self.rows, &recorded, compiler);
        wrong.extend(size::check(&self.sizes));
        let targets = self.targets();
        let unexpected = targets
            .iter()
            .filter(|target| !target.as_expected())
            .map(|target| {
                let Target {
                    what,
                    measured,
                    bound,
                    wanted,
                    unit,
                    ..
                } = target;
                let verdict = if target.met {
                    "target met that is listed as a known miss"
                } else {
                    "missed target"
                };
                format!("{verdict}: {what}: {measured:.1} {unit}, {bound} {wanted} wanted")
            });
        wrong.extend(unexpected);
        for line in &notes {
            eprintln!("note: {line}");
        }
        for line in &wrong {
            eprintln!("check: {line}");
        }
        if wrong.is_empty() {
            eprintln!("check: every chosen method stands");
            let missed = targets.iter().filter(|target| !target.met).count();
            eprintln!(
                "check: {} of {} targets are met; what is missed is known",
                targets.len() - missed,
                targets.len()
            );
            if recorded.contains_key(compiler) {
                eprintln!("check: no instruction count has grown by more than 5 %");
            }
        }
        Ok(wrong.is_empty())
    }
}

/// Runs it; false where a check fails.
pub fn run(arguments: &Arguments) -> Result<bool> {
    let report = Report::gather(arguments)?;
    if arguments.json {
        report.print_json()?;
    } else {
        println!("{}", report.text(&arguments.compiler, false));
    }
    if let Some(folder) = &arguments.out {
        report.write(folder, &arguments.compiler)?;
    }
    if let Some(path) = &arguments.results {
        let block = summary::block(
            &arguments.compiler,
            &report.rows,
            report.grasp.as_ref(),
            &report.delays,
            &report.targets(),
        );
        summary::write(path, &block)?;
    }
    if arguments.record {
        check::record(&arguments.recorded, &arguments.compiler, &report.rows)?;
    }
    if arguments.check {
        report.check(&arguments.recorded, &arguments.compiler)
    } else {
        Ok(true)
    }
}
