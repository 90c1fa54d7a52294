//! The closing summary of a mission, for a person.

use super::explain::explanation;
use crate::mission::{MissionOptions, MissionReport};
use std::fmt::Write;
use tactus_common::pose::PlanarPose;

/// The closing summary, a few lines.
pub fn closing(options: &MissionOptions, report: &MissionReport) -> String {
    let mut out = String::new();
    let pose = |p: &PlanarPose| {
        format!("({:+7.1}, {:+7.1}) mm  {:+6.2} deg", p.x_m * 1e3, p.y_m * 1e3, p.phi_rad.to_degrees())
    };
    let sd = report.believed_sd();
    let goal = options.scenario.goal(&options.truth);
    let head = if report.transported() { "The object stands at its goal." } else { "The task failed." };
    // Writing to a String cannot fail.
    let _ = writeln!(out, "\n{head}  ({}, seed {})\n", report.outcome_text(), options.seed);
    if let Some(why) = explanation(report) {
        let _ = writeln!(out, "  why         {why}");
    }
    let _ = writeln!(out, "  told        {}", pose(&options.guess));
    let _ = writeln!(out, "  true        {}", pose(&options.truth));
    let _ = writeln!(
        out,
        "  believed    {}   off by {:.2} mm, {:.2} deg after {} touch{} (sd {:.2}, {:.2} mm, {:.2} deg)",
        pose(&report.believed),
        report.position_error_m * 1e3,
        report.yaw_error_rad.to_degrees(),
        report.trials,
        if report.trials == 1 { "" } else { "es" },
        sd[0] * 1e3,
        sd[1] * 1e3,
        sd[2].to_degrees(),
    );
    let _ = writeln!(out, "  goal        {}", pose(&goal));
    let _ = writeln!(
        out,
        "  put down    {}   off by {:.2} mm, {:.2} deg",
        pose(&report.final_pose),
        report.goal_position_error_m * 1e3,
        report.goal_yaw_error_rad.to_degrees()
    );
    let _ = writeln!(
        out,
        "\n  {:.1} s of robot time in {:.1} s; {} error evaluations in {:.1} ms; {} CAN frames, bus load at most {:.0} %",
        report.sim_time_s,
        report.wall_time_s,
        report.evaluations,
        report.update_time_s() * 1e3,
        report.wire.frames,
        report.wire.load_max * 100.0
    );
    if let (Some(report), Some(digest)) = (report.digest, report.digest_text()) {
        let _ = writeln!(out, "  digest {digest} over {} ticks", report.ticks);
    }
    out
}
