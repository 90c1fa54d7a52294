//! Figures for people, not promises: `cargo test -p tactus-sim-host --release plan::tests::report -- --ignored --nocapture`.

use super::*;

#[test]
#[ignore = "report for people: cargo test -p tactus-sim-host --release plan -- --ignored --nocapture"]
fn report_shares_and_times() {
    let planner = planner();
    let mut random = Random::new(3);
    let mut q = home();
    let (mut times, mut durations, mut solved) = (Vec::new(), Vec::new(), 0);
    for _ in 0..200 {
        let pose = PlanarPose::new(random.within(0.0, 0.3), random.within(-0.2, 0.0), random.within(-PI, PI));
        let query = touch(q, pose, random.within(-PI, PI));
        let clock = std::time::Instant::now();
        let answer = planner.plan(&query);
        times.push(clock.elapsed().as_secs_f32() * 1e3);
        match answer {
            Ok(t) => {
                solved += 1;
                durations.push(t.duration());
                let touched = t.sample(99.0).unwrap().q_rad;
                let retreat = PlanQuery { purpose: Purpose::Retreat, start_q_rad: touched, ..query };
                match planner.plan(&retreat) {
                    Ok(t) => q = t.sample(99.0).unwrap().q_rad,
                    Err(e) => println!(
                        "retreat: {e} {touched:?} {} pre {:?}",
                        inverse::swivel(&touched),
                        t.knots.iter().map(|k| k.q_rad).collect::<Vec<_>>()
                    ),
                }
            }
            Err(e) => println!("{pose:?} {e} {query:?}"),
        }
    }
    times.sort_by(f32::total_cmp);
    durations.sort_by(f32::total_cmp);
    println!("touch: solved {solved}/200, plan ms median {} p90 {} max {}", times[100], times[180], times[199]);
    println!("duration s: median {} max {}", durations[durations.len() / 2], durations[durations.len() - 1]);
}

#[test]
#[ignore = "report for people"]
fn report_yaws() {
    let planner = planner();
    let (mut touches, mut carried, mut carried_without, mut count) = ([0; 4], [0; 4], [0; 4], 0);
    let mut durations = Vec::new();
    let (mut times, mut knots) = (Vec::new(), 0);
    for (x, y) in [
        (0.2, -0.1),
        (0.0, -0.1),
        (0.3, -0.1),
        (0.15, -0.2),
        (0.15, 0.0),
        (0.3, 0.0),
        (0.0, -0.2),
        (0.0, 0.0),
        (0.3, -0.2),
    ] {
        let mut lines = [String::new(), String::new()];
        for degrees in (-45..=45).step_by(15) {
            count += 1;
            let pose = PlanarPose::new(x, y, (degrees as f32).to_radians());
            for k in 0..4 {
                let mut query = touch(home(), pose, pose.phi_rad + k as f32 * FRAC_PI_2);
                let plain = planner.plan(&query);
                let mut next = query.goal_world_from_hand;
                next.translation.vector.x -= 0.5;
                query.purpose = Purpose::Grasp;
                query.next_world_from_hand = Some(next);
                let clock = std::time::Instant::now();
                let ahead = planner.plan(&query);
                times.push(clock.elapsed().as_secs_f32() * 1e3);
                touches[k] += usize::from(plain.is_ok());
                let carry = |t: &Trajectory| planner.plan(&transport(t.sample(99.0).unwrap().q_rad, pose));
                let without = plain.as_ref().map(carry);
                let with = ahead.as_ref().map(carry);
                carried_without[k] += usize::from(matches!(without, Ok(Ok(_))));
                carried[k] += usize::from(matches!(with, Ok(Ok(_))));
                if let Ok(Ok(t)) = &with {
                    durations.push(t.duration());
                    knots = knots.max(t.knots.len());
                    if x == 0.2 {
                        let rests: Vec<f32> = t
                            .knots
                            .iter()
                            .filter(|k| k.qd_rad_s == [0.0; 7])
                            .map(|k| (k.t_s * 100.0).round() / 100.0)
                            .collect();
                        println!("transport rests at {rests:?} s, {} knots", t.knots.len());
                    }
                }
                let code = |ok: bool, c: &str| if ok { c.to_owned() } else { "-".to_owned() };
                lines[0] += &format!(
                    "{}{}{} ",
                    code(plain.is_ok(), "T"),
                    code(matches!(without, Ok(Ok(_))), "c"),
                    code(matches!(with, Ok(Ok(_))), "C")
                );
                if let Ok(Err(e)) = &with {
                    lines[1] += &format!("[{degrees} {k} {e}] ");
                }
                if let Err(e) = &plain {
                    lines[1] += &format!("[{degrees} {k} touch {e}] ");
                }
            }
            lines[0] += "| ";
        }
        println!("({x},{y}) {}\n   {}", lines[0], lines[1]);
    }
    durations.sort_by(f32::total_cmp);
    times.sort_by(f32::total_cmp);
    println!("of {count} each: touch {touches:?} carried after plain {carried_without:?} after lookahead {carried:?}");
    println!(
        "transport s median {} max {}, knots {knots}; lookahead plan ms median {} max {}",
        durations[durations.len() / 2],
        durations[durations.len() - 1],
        times[times.len() / 2],
        times[times.len() - 1]
    );
}
