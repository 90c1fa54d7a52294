//! Plausible outputs of every kind of experiment: made up, for looking at the page and for its test.

use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

const TRUTH: [f64; 2] = [0.2, -0.1];

/// A small generator of uniform numbers in [0, 1).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn grid() -> Vec<(f64, f64)> {
    (0..21).flat_map(|i| (0..23).map(move |j| (0.1 + 0.01 * f64::from(i), -0.15 + 0.005 * f64::from(j)))).collect()
}

fn write(dir: &Path, stem: &str, experiment: &str, settings: Value, statistics: Value, csv: &str) {
    let mut title = format!("{experiment}: {}", stem.replace('-', " "));
    if stem == "surface-modified" {
        title = "E_mod <script>alert('x')</script> & co".into();
    }
    let meta = json!({
        "experiment": experiment,
        "title": title,
        "command": format!("tactus {experiment} --seed 1 --csv {stem}.csv"),
        "settings": settings,
        "truth": {"x": TRUTH[0], "y": TRUTH[1], "phi": 0.0},
        "grid": {"x": [0.1, 0.3, 0.01], "y": [-0.15, -0.04, 0.005], "phi": [0.0, 0.0, 0.0]},
        "statistics": statistics,
        "machine": {"cpu": "Example CPU at 3 GHz", "cores": 2, "os": "linux", "rustc": "1.90.0", "version": "0.1.0"},
        "wall_time_s": 321.5,
    });
    std::fs::write(dir.join(format!("{stem}.json")), serde_json::to_string_pretty(&meta).unwrap()).unwrap();
    std::fs::write(dir.join(format!("{stem}.csv")), csv).unwrap();
}

fn settings(error: &str, optimizer: &str) -> Value {
    json!({"error": error, "optimizer": optimizer, "predictor": "simulation", "formulation": "replan", "gradient": "two-sided",
        "sensors": "ideal", "noise": false, "dof": 2, "damping": 5.0f32, "instants": 20, "seed": 1})
}

fn surface(dir: &Path, stem: &str, error: &str, value: impl Fn(f64, f64) -> f64) {
    let mut csv = String::from("x,y,phi,error,outcome\n");
    for (x, y) in grid() {
        if x > 0.275 && y > -0.075 {
            let reason = if y > -0.055 { "no inverse kinematics" } else { "no collision-free path" };
            writeln!(csv, "{},{},0,,{reason}", x as f32, y as f32).unwrap();
        } else {
            writeln!(csv, "{},{},0,{},ok", x as f32, y as f32, value(x - TRUTH[0], y - TRUTH[1]) as f32).unwrap();
        }
    }
    write(dir, stem, "surface", settings(error, "none"), json!({}), &csv);
}

fn surfaces(dir: &Path) {
    surface(dir, "surface-weighted", "weighted", |dx, dy| {
        (8.0 * (dx.abs() * 40.0 + dy.abs() * 90.0 - 1.0).max(0.0)).round() / 4.0
    });
    surface(dir, "surface-modified", "modified", |dx, dy| {
        (dx.abs() * 40.0 + dy.abs() * 90.0).floor() + 30.0 * (dx * dx + 3.0 * dy * dy) + 0.3 * (dx * 200.0).cos().abs()
    });
    surface(dir, "surface-geometric", "geometric", |dx, dy| 1e6 * (dx * dx + 2.0 * dy * dy) + 0.4);
}

/// A map: converged within `basin` metres of x, with location errors of about `off` metres.
fn map(dir: &Path, stem: &str, settings: Value, basin: f64, off: f64, phis: &[f64]) {
    let mut dice = Dice(stem.len() as u64 + 7);
    let mut csv =
        String::from("x,y,phi,class,final_error,location_error_m,yaw_error_rad,evaluations,time_s,stop_reason\n");
    let mut evaluations = 0.0;
    for phi in phis {
        for (x, y) in grid() {
            let reach = (x - TRUTH[0]).abs() + phi.abs() * 0.1 + 0.01 * dice.roll();
            let (class, error, location, reason) = match reach {
                r if r < basin => ("converged", 0.5 * dice.roll(), off * (0.2 + dice.roll()), "threshold"),
                r if r < basin * 1.4 => ("direction", 3.0 + dice.roll(), 0.02 + 0.03 * dice.roll(), "step too small"),
                _ => ("failed", 6.0 + dice.roll(), 0.05 + 0.1 * dice.roll(), "no descent"),
            };
            let used = (20.0 + 60.0 * dice.roll()).round();
            evaluations += used;
            let time = used * 1.1e-4;
            writeln!(
                csv,
                "{},{},{phi},{class},{error},{location},{},{used},{time},{reason}",
                x as f32,
                y as f32,
                0.01 * dice.roll()
            )
            .unwrap();
        }
    }
    let starts = (grid().len() * phis.len()) as f64;
    let statistics = json!({"optimiser_time_s": evaluations * 1.1e-4, "evidence_time_s": starts * 0.35, "evaluations_mean": evaluations / starts});
    write(dir, stem, "converge", settings, statistics, &csv);
}

fn maps(dir: &Path) {
    let published = || settings("modified", "steepest-descent-golden-section");
    let with = |key: &str, value: Value| {
        let mut changed = published();
        changed[key] = value;
        changed
    };
    let default = |noise: bool, dof: u8| json!({"error": "geometric", "optimizer": "levenberg-marquardt", "sensors": "real", "noise": noise, "dof": dof, "seed": 1});
    map(dir, "converge-default", default(false, 2), 1.0, 0.0004, &[0.0]);
    map(dir, "converge-default-noise", default(true, 2), 1.0, 0.002, &[0.0]);
    map(dir, "converge-published", published(), 0.06, 0.008, &[0.0]);
    map(dir, "converge-published-one-sided", with("gradient", "one-sided".into()), 0.05, 0.009, &[0.0]);
    map(dir, "converge-published-damping-1", with("damping", 1.0.into()), 0.045, 0.009, &[0.0]);
    map(dir, "converge-published-damping-20", with("damping", 20.0.into()), 0.055, 0.009, &[0.0]);
    map(dir, "converge-default-3dof", default(false, 3), 0.09, 0.001, &[-0.7, -0.35, 0.0, 0.35, 0.7]);
}

fn compare(dir: &Path) {
    let optimizers = [
        ("annealing", 0.35),
        ("brent", 0.5),
        ("cma-es", 0.7),
        ("conjugate-gradients", 0.6),
        ("direct", 0.8),
        ("hybrid", 0.62),
        ("levenberg-marquardt", 1.0),
        ("newton", 0.55),
        ("steepest-descent-golden-section", 0.52),
        ("steepest-descent-simple", 0.45),
    ];
    let mut dice = Dice(3);
    let mut csv = String::from(
        "problem,dof,error,optimizer,budget,location_error_m,yaw_error_rad,final_error,evaluations,time_s,stop_reason,observability\n",
    );
    for (dof, error) in [(2, "modified"), (2, "geometric"), (3, "geometric")] {
        for (optimizer, skill) in optimizers {
            for budget in [10u32, 30, 100, 300, 1000] {
                for problem in 0..40 {
                    let power = skill * f64::from(budget).log10() * if error == "geometric" { 1.5 } else { 0.7 }
                        / f64::from(dof - 1);
                    let location = 0.08 * 10f64.powf(-power * (0.4 + dice.roll()));
                    let seen = if problem % 7 == 0 { "not observable" } else { "observable" };
                    let used = f64::from(budget) * (0.6 + 0.4 * dice.roll());
                    writeln!(
                        csv,
                        "p{problem},{dof},{error},{optimizer},{budget},{location},0.01,0.3,{},{},budget,{seen}",
                        used.round(),
                        used * 9e-6
                    )
                    .unwrap();
                }
            }
        }
    }
    write(dir, "compare", "compare", json!({"seed": 1, "problems": 40, "noise": true}), json!({}), &csv);
}

fn trials(dir: &Path) {
    let mut dice = Dice(11);
    let mut csv =
        String::from("seed,position_error_m,yaw_error_rad,sd_x_m,sd_y_m,confidently_wrong,trials,outcome,class\n");
    for seed in 1..=300 {
        let gauss = (-2.0 * dice.roll().max(1e-12).ln()).sqrt() * (TAU * dice.roll()).cos();
        let (class, location) = match dice.roll() {
            r if r < 0.93 => ("located", 0.0006 * gauss.exp()),
            r if r < 0.98 => ("not observable", 0.01 * (0.5 * gauss).exp()),
            _ => ("wrong", 0.02 * gauss.exp()),
        };
        let sure = class == "wrong" && dice.roll() < 0.5;
        let outcome = if class == "wrong" { "refused: no grasp reachable" } else { "transported" };
        writeln!(
            csv,
            "{seed},{location},{},0.0004,0.0005,{sure},{},{outcome},{class}",
            0.004 * dice.roll(),
            2 + seed % 3
        )
        .unwrap();
    }
    let by_touch = json!([
        {"touches": 1, "located": 12, "not_observable": 286, "wrong": 2, "ambiguous": 260},
        {"touches": 2, "located": 213, "not_observable": 82, "wrong": 5},
        {"touches": 3, "located": 268, "not_observable": 27, "wrong": 5},
        {"touches": 4, "located": 279, "not_observable": 15, "wrong": 6},
    ]);
    let settings =
        json!({"error": "geometric", "optimizer": "levenberg-marquardt", "dof": 3, "noise": true, "seed": 1});
    write(dir, "trials", "trials", settings, json!({"missions": 300, "by_touch": by_touch}), &csv);
}

/// Writes one directory with everything, and a file that is nothing.
pub fn write_all(dir: &Path) {
    surfaces(dir);
    maps(dir);
    compare(dir);
    trials(dir);
    let bench = json!([
        {"name": "update, Levenberg-Marquardt", "value": 0.41, "unit": "ms", "note": "median of 200"},
        {"name": "world steps, 1 thread", "value": 6912.0, "unit": "1/s", "note": ""},
        {"name": "against argmin", "value": 3.7, "unit": "ratio", "note": "steepest descent, same problems"},
    ]);
    let bench = json!({"experiment": "bench", "command": "cargo xtask bench", "machine": {"cpu": "Example CPU", "cores": 2}, "figures": bench,
        "table": [{"crate": "tactus", "optimizer": "levenberg-marquardt", "budget": 100, "location_error_median_m": 0.0005,
            "within_2mm": 1.0, "evaluations_median": 85, "time_median_s": 1.7e-4, "time_to_default": 1.0, "note": ""}]});
    std::fs::write(dir.join("bench.json"), bench.to_string()).unwrap();
    std::fs::write(dir.join("notes.txt"), "not an experiment").unwrap();
}
