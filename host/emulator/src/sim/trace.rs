// SPDX-License-Identifier: GPL-2.0-only
//! A recording: what a chip could measure, and the simulation's truth.

use std::io::{BufWriter, Write};
use std::path::Path;

use palpate_plant::Plant;

/// Columns of the file.
const HEADER: &str = "time_s,encoder_counts,current_a,duty,true_theta_a_rad,true_torque_nm,true_theta_1_rad,\
                      true_theta_2_rad,true_motor_current_a,true_motor_speed_rad_per_s,true_phalanx,true_k_mm,true_force_n";

/// A CSV file being written.
pub struct Trace {
    file: BufWriter<std::fs::File>,
}

impl Trace {
    /// Creates the file and writes its header.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn create(path: &Path) -> std::io::Result<Self> {
        let mut file = BufWriter::new(std::fs::File::create(path)?);
        writeln!(file, "{HEADER}")?;
        Ok(Self { file })
    }

    /// One row. The current is what the sense shows, with the sign of the drive direction.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn row(&mut self, time_s: f64, plant: &Plant) -> std::io::Result<()> {
        let truth = plant.truth();
        let sign = if truth.pins.closing { 1.0 } else { -1.0 };
        let current_a = plant.sensed_a();
        let driven = truth.pins.awake && truth.pins.outputs_enabled;
        let duty = if driven { sign * truth.pins.duty } else { 0.0 };
        let (phalanx, k_mm, force_n) = match truth.strongest() {
            Some(contact) => (
                contact.phalanx.to_string(),
                format!("{:.4}", 1e3 * contact.k_m),
                contact.force_n,
            ),
            None => (String::new(), String::new(), 0.0),
        };
        writeln!(
            self.file,
            "{time_s:.6},{},{current_a:.7},{duty:.5},{:.7},{:.6},{:.6},{:.6},{:.7},{:.3},{phalanx},{k_mm},{force_n:.5}",
            plant.encoder_count(),
            truth.theta_a_rad,
            truth.torque_nm,
            truth.joint_rad[0],
            truth.joint_rad[1],
            truth.motor_current_a,
            truth.motor_speed_rad_per_s,
        )
    }

    /// Writes what is still buffered.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}
