//! Motion in the vertical plane over a tick: the equations of `dynamics` integrated along a plane path at a held speed. `body` performs the
//! integration.

use crate::{Restoring, environment::Environment, vehicle::Derivatives};

/// A refused step: the result would be outside the range of any vehicle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("step refused, the motion diverges: {quantity} would be {value}, beyond {limit}")]
pub struct Diverged {
    /// Quantity out of range, with its unit.
    pub quantity: &'static str,
    /// Value that the step would give; may be infinite or NaN.
    pub value: f64,
    /// Largest allowed magnitude.
    pub limit: f64,
}

/// Parameters of the motion in the vertical plane over a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Derivatives of the vehicle at its speed.
    pub derivatives: Derivatives,
    /// Dependence of the restoring moment on pitch.
    pub restoring: Restoring,
    /// Water and gravity.
    pub environment: Environment,
    /// Longest integration step \[s\]; the error estimate may shorten it.
    pub step: f64,
}

/// The manoeuvres of Brunner 1988, App. A, in consistent units.
#[cfg(test)]
mod tests {
    use planesman_testing::near;
    use planesman_units::FOOT;

    use super::*;
    use crate::{PlanePath, State, vehicle_file::brunner};

    /// 30 degrees as the programs write it \[rad\].
    #[allow(clippy::approx_constant)]
    const THIRTY_DEGREES: f64 = 0.523_598_7;

    const FRESH: Environment = Environment {
        density: 999.835,
        gravity: 9.81456,
        atmospheric_pressure: 101_325.0,
    };

    fn at_one_foot_per_second(restoring: Restoring) -> Motion {
        Motion {
            derivatives: brunner().derivatives(FOOT),
            restoring,
            environment: FRESH,
            step: 0.001,
        }
    }

    /// The results of a dive with the planes held for a time, then neutral until 60 s.
    struct Dive {
        pitch_at_release: f64,
        steepest_pitch: f64,
        depth_at_release: f64,
        final_depth: f64,
        time_to_one_foot: f64,
    }

    /// In degrees, feet and seconds.
    fn dive(motion: &Motion, held_for: f64) -> Dive {
        let steps = |seconds: f64| (seconds / motion.step).round() as u32;
        let mut state = State::default();
        let mut steepest = 0.0_f64;
        let mut time_to_one_foot = None;
        let mut at_release = state;
        for k in 0..steps(60.0) {
            let delta = if k < steps(held_for) {
                THIRTY_DEGREES
            } else {
                0.0
            };
            state = motion
                .advance(&state, &PlanePath::held(&delta), 1)
                .expect("it dives");
            steepest = steepest.min(state.pitch);
            if state.depth >= FOOT && time_to_one_foot.is_none() {
                time_to_one_foot = Some(f64::from(k + 1) * motion.step);
            }
            if k + 1 == steps(held_for) {
                at_release = state;
            }
        }
        Dive {
            pitch_at_release: at_release.pitch.to_degrees(),
            steepest_pitch: steepest.to_degrees(),
            depth_at_release: at_release.depth / FOOT,
            final_depth: state.depth / FOOT,
            time_to_one_foot: time_to_one_foot.expect("it passes one foot"),
        }
    }

    #[test]
    fn thirty_degrees_of_plane_for_ten_seconds_dive_nine_feet() {
        let dive = dive(&at_one_foot_per_second(Restoring::Sine), 10.0);
        near(dive.pitch_at_release, -51.387_687_027, 1e-5);
        near(dive.steepest_pitch, -51.494_970_544, 5e-5);
        near(dive.depth_at_release, 5.014_305, 1e-5);
        near(dive.final_depth, 9.097_560_425, 1e-5);
        near(dive.time_to_one_foot, 4.155, 1e-9);
    }

    #[test]
    fn the_small_angle_restoring_moment_holds_the_bow_three_degrees_higher() {
        let dive = dive(&at_one_foot_per_second(Restoring::SmallAngle), 10.0);
        near(dive.pitch_at_release, -47.966_393_916, 1e-5);
        near(dive.steepest_pitch, -47.998_332_543, 5e-5);
        near(dive.final_depth, 8.502, 5e-4);
        near(dive.time_to_one_foot, 4.158, 1e-9);
    }

    #[test]
    fn with_the_arm_in_inches_for_feet_the_printed_four_degrees_come_out() {
        // C2 = 1.27, twelve times what it should be: Brunner 1988, p. 39, prints -4.2 degrees.
        let mut motion = at_one_foot_per_second(Restoring::SmallAngle);
        motion.derivatives.restoring *= 12.0;
        let ten_seconds = dive(&motion, 10.0);
        near(ten_seconds.pitch_at_release, -4.191_603_501, 1e-5);
        near(ten_seconds.steepest_pitch, -5.744_806, 5e-5);
        near(ten_seconds.final_depth, 1.112_498, 1e-5);
        // Ten of the program's units of time L / U: the thesis prints 2.61 ft.
        let ten_units = dive(&motion, 10.0 * 28.0 / 12.0);
        near(ten_units.final_depth, 2.596, 2e-3);
    }

    /// Program T3: the pitch equation alone.
    fn without_heave(mut motion: Motion) -> Motion {
        motion.derivatives.z_w = 0.0;
        motion.derivatives.z_q_plus_m_u = 0.0;
        motion.derivatives.z_delta = 0.0;
        motion.derivatives.m_w = 0.0;
        motion
    }

    #[test]
    fn without_heave_the_vehicle_dives_a_little_steeper_and_hardly_less_deep() {
        // Program T3; the thesis' 32 % less depth comes of the arm in inches.
        let dive = dive(
            &without_heave(at_one_foot_per_second(Restoring::Sine)),
            10.0,
        );
        near(dive.pitch_at_release, -51.614_626_781, 1e-5);
        near(dive.steepest_pitch, -51.746, 1e-3);
        near(dive.final_depth, 9.077_789_722, 1e-5);
    }

    #[test]
    fn one_second_of_plane_without_restoring_turns_the_bow_down_twelve_degrees() {
        // Program T4 in real seconds.
        let mut motion = without_heave(at_one_foot_per_second(Restoring::Sine));
        motion.derivatives.restoring = 0.0;
        let dive = dive(&motion, 1.0);
        near(dive.pitch_at_release, -4.913_874_140, 1e-5);
        near(dive.steepest_pitch, -11.828_569, 1e-5);
    }

    #[test]
    fn with_a_tenth_of_the_damping_the_vehicle_loops() {
        // Program T5.
        let mut motion = at_one_foot_per_second(Restoring::Sine);
        motion.derivatives.m_q *= 0.1;
        let dive = dive(&motion, 10.0);
        near(dive.pitch_at_release, -205.508_205, 1e-4);
        near(dive.time_to_one_foot, 3.265, 6e-3);
    }

    #[test]
    fn one_second_of_plane_without_restoring_or_heave_gives_the_printed_angle_per_length() {
        // Program T4, p. 40: 30 degrees for one unit of time L/U turn the bow by
        // M'delta / M'q x 30 degrees = 27.6; the thesis prints -27.5.
        let mut motion = without_heave(at_one_foot_per_second(Restoring::Sine));
        motion.derivatives.restoring = 0.0;
        let unit = brunner().reference_length / FOOT;
        motion.step = unit / 2000.0;
        let held = motion
            .advance(&State::default(), &PlanePath::held(&THIRTY_DEGREES), 2000)
            .expect("it turns");
        let settled = motion
            .advance(&held, &PlanePath::held(&0.0), 40_000)
            .expect("it settles");
        near(settled.pitch.to_degrees(), -27.600, 1e-3);
    }

    #[test]
    fn the_longest_step_changes_nothing_that_matters() {
        let run = |step: f64, steps: u32| {
            let motion = Motion {
                step,
                ..at_one_foot_per_second(Restoring::Sine)
            };
            let ramp = [0.0, 0.5];
            let path = PlanePath::new(&ramp, 10_000_000_000, 10_000_000_000).expect("a ramp");
            motion
                .advance(&State::default(), &path, steps)
                .expect("it dives")
        };
        let finest = run(1e-4, 100_000);
        for (step, steps) in [(10.0, 1), (0.1, 100), (0.05, 200), (0.001, 10_000)] {
            let found = run(step, steps);
            near(found.depth, finest.depth, 1e-9);
            near(found.pitch, finest.pitch, 1e-9);
        }
    }

    #[test]
    fn up_and_down_are_mirror_images_far_from_the_surface() {
        let motion = at_one_foot_per_second(Restoring::Sine);
        let deep = State {
            depth: 100.0,
            ..State::default()
        };
        let go = |delta: f64| {
            motion
                .advance(&deep, &PlanePath::held(&delta), 10_000)
                .expect("it moves")
        };
        let (down, up) = (go(0.3), go(-0.3));
        assert_eq!(down.pitch, -up.pitch);
        assert_eq!(down.heave, -up.heave);
        assert_eq!(down.distance, up.distance);
        assert!((down.depth + up.depth - 200.0).abs() < 1e-12);
    }

    #[test]
    fn without_way_on_the_vehicle_swings_as_a_pendulum() {
        let motion = Motion {
            derivatives: brunner().derivatives(0.0),
            ..at_one_foot_per_second(Restoring::Sine)
        };
        let d = motion.derivatives;
        // Small swings: period 2 pi sqrt((I_y - M_qdot) / (W BG)) = 12.08 s.
        let period = std::f64::consts::TAU * (d.pitch_inertia / d.restoring).sqrt();
        let start = State {
            depth: 1.0,
            pitch: 0.01,
            ..State::default()
        };
        let steps = (period / motion.step).round() as u32;
        let after = motion
            .advance(&start, &PlanePath::held(&0.5), steps)
            .expect("it swings");
        near(period, 12.08, 0.01);
        near(after.pitch, 0.01, 1e-8);
        assert_eq!(after.depth, 1.0);
    }

    #[test]
    fn a_vehicle_climbing_to_the_surface_stays_at_it() {
        let motion = at_one_foot_per_second(Restoring::Sine);
        let after = motion
            .advance(&State::default(), &PlanePath::held(&-0.3), 10_000)
            .expect("it stays");
        assert_eq!(after.depth, 0.0);
    }

    #[test]
    fn a_motion_that_blows_up_is_refused() {
        let mut motion = at_one_foot_per_second(Restoring::Sine);
        motion.derivatives.m_q *= -1.0;
        let diverged = motion
            .advance(&State::default(), &PlanePath::held(&0.5), 1_000_000)
            .expect_err("it turns ever faster");
        assert!(!(-diverged.limit..=diverged.limit).contains(&diverged.value));
    }
}
