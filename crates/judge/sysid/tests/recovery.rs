//! Known parameters come back from simulated measurements, and what cannot come back is said so.

use paid_lanes::Isa;
use paid_mujoco::Library;
use paid_physics::{BallParams, Combine, Material, SceneConfig};
use paid_sysid::confidence::Verdict;
use paid_sysid::csv::Run;
use paid_sysid::options::{Starts, with_parameters};
use paid_sysid::plausible::check_fit;
use paid_sysid::simulate::{Experiment, FifaFigures, Measurements, MujocoBall, Source, simulate};
use paid_sysid::{Identification, Options, Repeats, Surface, SysidError, identify};

/// The ground of the soccer task.
fn scene() -> SceneConfig {
    SceneConfig {
        ground: Material { static_friction: 1.0, dynamic_friction: 1.0, restitution: 0.8 },
        ground_friction_combine: Combine::Multiply,
        ground_restitution_combine: Combine::Multiply,
        ..SceneConfig::default()
    }
}

fn options() -> Options {
    Options { restarts: 4, ..Options::default() }
}

fn fit(data: &Measurements, options: &Options) -> Identification {
    let ball = BallParams::default();
    identify(&data.drops, &data.rolls, &ball, &scene(), Isa::detect(), options).expect("identifies")
}

fn film(truth: &[f64; 5], experiment: &Experiment) -> Measurements {
    let ball = with_parameters(&BallParams::default(), truth);
    simulate(experiment, &Source::Engine { ball, scene: scene(), isa: Isa::detect() }).expect("simulates")
}

const HARD: [f64; 5] = [0.77, 0.07, 0.75, 0.01, 4.28];
const GRASS: [f64; 5] = [0.98, 0.15, 0.71, 0.01, 4.95];

#[test]
fn the_papers_surfaces_come_back_within_five_percent_where_they_are_seen() {
    for (name, truth) in [("hard", HARD), ("grass", GRASS)] {
        let found = fit(&film(&truth, &Experiment::default()), &options());
        assert!(found.remarks().iter().any(|r| r.contains("--starts refined")));
        let e = &found.confidence.estimates;
        for i in [2, 4] {
            assert!((e[i].value - truth[i]).abs() < 0.05 * truth[i], "{name}: {:?}", e[i]);
            assert_ne!(e[i].verdict, Verdict::Unseen, "{name}: {:?}", e[i]);
        }
        // A hundredth of its range, but not 5% of a value that is nearly nothing.
        assert!((e[3].value - truth[3]).abs() < 0.05, "{name}: {:?}", e[3]);
        assert_ne!(e[3].verdict, Verdict::Sharp);
        // A rolling ball does not feel the dynamic friction; of the static one it needs only enough.
        for i in [0, 1] {
            assert_eq!(e[i].verdict, Verdict::Unseen, "{name}: {:?}", e[i]);
        }
        assert!((0.2..0.6).contains(&e[0].flat[0]) && e[0].flat[1] == 1.0, "{name}: {:?}", e[0]);
        // What is not seen stays as it was put in.
        let known = BallParams::default().material;
        assert_eq!(found.ball.material.static_friction, known.static_friction);
        assert_eq!(found.ball.material.dynamic_friction, known.dynamic_friction);
        assert!(found.remarks().iter().any(|r| r.contains("dynamic_friction cannot be identified")));
    }
}

#[test]
fn refined_starts_leave_nothing_but_the_cameras_noise() {
    let data = film(&GRASS, &Experiment::default());
    let found = fit(&data, &Options { starts: Starts::Refined, ..options() });
    for rms in [found.drop_rms_m, found.roll_rms_m] {
        assert!((0.004..0.0056).contains(&rms.expect("both were filmed")), "{rms:?}");
    }
    let e = &found.confidence.estimates[4];
    assert!((e.value - GRASS[4]).abs() < 0.02 * GRASS[4] && e.verdict == Verdict::Sharp, "{e:?}");
    let table = found.table(Some(&GRASS));
    assert!(table.contains("angular_damping") && table.contains("truth"), "{table}");
}

#[test]
fn without_noise_a_large_damping_comes_back_within_five_percent() {
    let truth = [0.9, 0.3, 0.8, 0.3, 2.0];
    let found = fit(&film(&truth, &Experiment { noise_m: 0.0, ..Experiment::default() }), &options());
    for i in [2, 3, 4] {
        let e = &found.confidence.estimates[i];
        assert!((e.value - truth[i]).abs() < 0.05 * truth[i], "{e:?}");
    }
    assert!(
        found.confidence.correlation[3][4].expect("both seen") < 0.0,
        "they share the rolling resistance"
    );
}

#[test]
fn a_ball_that_starts_sliding_shows_the_dynamic_friction() {
    let truth = GRASS;
    let mut data = film(&truth, &Experiment::default());
    let slides = film(&truth, &Experiment { spin: 0.0, speed: 4.0, ..Experiment::default() }).rolls;
    data.rolls.extend(slides.into_iter().map(|run| Run { spin: Some(0.0), ..run }));
    let found = fit(&data, &Options { starts: Starts::Refined, ..options() });
    println!("{}", found.table(Some(&truth)));
    for i in [1, 2, 4] {
        let e = &found.confidence.estimates[i];
        assert!((e.value - truth[i]).abs() < 0.05 * truth[i], "{e:?}");
        assert_ne!(e.verdict, Verdict::Unseen, "{e:?}");
    }
}

#[test]
fn averaged_repeats_give_the_same_ball() {
    let data = film(&HARD, &Experiment { noise_m: 0.002, ..Experiment::default() });
    let found = fit(&data, &Options { repeats: Repeats::Mean, ..options() });
    assert_eq!((found.drops.len(), found.rolls.len(), found.repeats.len()), (1, 1, 5));
    let e = &found.confidence.estimates;
    assert!((e[4].value - HARD[4]).abs() < 0.05 * HARD[4], "{:?}", e[4]);
}

#[test]
fn equal_seeds_give_equal_results() {
    let data = film(&HARD, &Experiment::default());
    let options = Options { restarts: 2, generations: 30, ..Options::default() };
    let (a, b) = (fit(&data, &options), fit(&data, &options));
    assert_eq!((a.ball, a.loss), (b.ball, b.loss));
    assert!(a.searches.iter().all(|s| s.curve.windows(2).all(|w| w[1] <= w[0])));
}

#[test]
fn measurements_of_other_physics_are_reproduced_to_a_few_centimeters() {
    let mut sources = vec![Source::Fifa(FifaFigures::TURF)];
    let test = "measurements_of_other_physics_are_reproduced_to_a_few_centimeters";
    if paid_testing::mujoco(test, Library::get()).is_some() {
        sources.push(Source::Mujoco(MujocoBall::default()));
    }
    for source in sources {
        let data = simulate(&Experiment::default(), &source).expect("simulates");
        let found = fit(&data, &Options { starts: Starts::Refined, ..options() });
        assert!(found.drop_rms_m.expect("drops") < 0.05, "{:?}", found.drop_rms_m);
        assert!(found.roll_rms_m.expect("rolls") < 0.05, "{:?}", found.roll_rms_m);
        check_fit(&found, &data.drops).expect("it meets the films");
        let text = Surface::of("yard", &found).to_toml(&[]).expect("writes");
        let back = Surface::parse("yard.toml".as_ref(), &text).expect("reads");
        assert!((back.ball_params.material.restitution - found.ball.material.restitution).abs() < 1e-5);
    }
}

#[test]
fn a_ground_that_swallows_the_bounce_is_remarked_upon() {
    // Steel returns 0.85 of the speed, this ground at most 0.8.
    let data = simulate(&Experiment::default(), &Source::Fifa(FifaFigures::STEEL)).expect("simulates");
    let found = fit(&data, &options());
    assert!(found.confidence.estimates[2].at_bound);
    assert!(
        found.remarks().iter().any(|r| r.starts_with("restitution ended at an end")),
        "{:?}",
        found.remarks()
    );
    let error = check_fit(&found, &data.drops).expect_err("decimeters off").to_string();
    assert!(
        error.contains("meets the drops to 5") && error.contains("scene.ground.restitution=1"),
        "{error}"
    );
    assert!(found.roll_rms_m.is_none() && found.confidence.estimates[4].verdict == Verdict::Unseen);
}

#[test]
fn heights_of_the_balls_center_are_no_fit() {
    let mut data = film(&GRASS, &Experiment { rate_hz: 60.0, ..Experiment::default() });
    let found = fit(&data, &Options { starts: Starts::Refined, ..options() });
    check_fit(&found, &data.drops).expect("it meets the films");
    for drop in &mut data.drops {
        drop.values.iter_mut().for_each(|height| *height += 0.11);
    }
    let found = fit(&data, &Options { starts: Starts::Refined, ..options() });
    let error = check_fit(&found, &data.drops).expect_err("refused").to_string();
    assert!(
        error.contains("heights of the ball's center") && error.contains("nothing was written"),
        "{error}"
    );
}

#[test]
fn nothing_measured_is_an_error() {
    let ball = BallParams::default();
    let result = identify(&[], &[], &ball, &scene(), Isa::detect(), &Options::default());
    assert!(matches!(result, Err(SysidError::Option { .. })));
}
