//! Hand-made sequences of images: what the memory returns.

use paid_track::{
    BallMemory, BallState, Candidate, Glance, Measurement, MemoryPreset, Rolling, TrackedBall, TrackerPreset,
};

const STEP_S: f64 = 0.04;
const AGE_S: f64 = 0.06;

/// A robot that looks 25 times a second at balls on a floor.
struct Story {
    memory: BallMemory,
    rolling: Rolling<f64>,
    time_s: f64,
    pictures: u32,
}

impl Story {
    fn new() -> Self {
        let memory = BallMemory::new(MemoryPreset::default(), TrackerPreset::default());
        Self { memory, rolling: Rolling { decay: 0.0, to_strike_s: f64::INFINITY }, time_s: 0.0, pictures: 0 }
    }

    /// One image with detections at these places, each off by a centimeter to a side that alternates; `shows` as in [`Glance`].
    fn look_with(&mut self, places: &[[f64; 2]], shows: &dyn Fn([f64; 2]) -> bool) -> Option<usize> {
        self.time_s += STEP_S;
        self.rolling.to_strike_s -= STEP_S;
        self.memory.advance(STEP_S, 0.1, &self.rolling);
        self.pictures += 1;
        let off = if self.pictures.is_multiple_of(2) { 0.01 } else { -0.01 };
        let finds: Vec<Candidate> = places
            .iter()
            .map(|[x, y]| Candidate {
                measurement: Measurement {
                    position: [x + off, *y],
                    variance: 4e-4,
                    age_s: AGE_S,
                    seen: true,
                },
                score: 0.8,
            })
            .collect();
        self.memory.look(&Glance { age_s: AGE_S, finds: &finds, shows }, &self.rolling)
    }

    fn look(&mut self, places: &[[f64; 2]]) -> Option<usize> {
        self.look_with(places, &|_| true)
    }

    fn own(&self) -> TrackedBall {
        self.memory.own(&self.rolling).expect("a ball")
    }

    fn is_near(&self, place: [f64; 2], within_m: f64) -> bool {
        let [x, y] = self.own().belief.ball.position;
        (x - place[0]).hypot(y - place[1]) < within_m
    }
}

#[test]
fn a_ball_is_confirmed_by_its_third_image_and_a_single_flash_never() {
    let mut story = Story::new();
    story.look(&[[1.0, 0.0]]);
    story.look(&[[1.0, 0.0]]);
    assert!(story.memory.own(&story.rolling).is_none());
    story.look(&[[1.0, 0.0]]);
    assert_eq!(story.own().state, BallState::Seen);
    let mut story = Story::new();
    for k in 0..40 {
        // Something else flashes at another place in every fourth image.
        let place = [0.5 + 0.05 * f64::from(k), 0.8];
        story.look(if k % 4 == 0 { std::slice::from_ref(&place) } else { &[] });
    }
    assert!(story.memory.own(&story.rolling).is_none());
}

#[test]
fn out_of_the_picture_it_is_remembered_for_seconds_and_in_it_without_a_ball_it_is_lost() {
    let mut story = Story::new();
    for _ in 0..20 {
        story.look(&[[1.0, 0.3]]);
    }
    for _ in 0..100 {
        story.look_with(&[], &|_| false);
    }
    let own = story.own();
    assert_eq!(own.state, BallState::Remembered);
    // 100 steps of 0.04 s after an image that was 0.06 s old.
    assert!((own.belief.age_s - 4.06).abs() < 1e-9 && story.is_near([1.0, 0.3], 0.03), "{own:?}");
    // Odds of 100 times 0.6^10 are 0.6, times 0.6^11 below the half.
    for k in 1..=12 {
        story.look(&[]);
        assert_eq!(story.own().state == BallState::Lost, k >= 11, "image {k}");
    }
}

#[test]
fn behind_the_own_leg_it_stays_remembered() {
    let mut story = Story::new();
    for _ in 0..10 {
        story.look(&[[0.6, 0.1]]);
    }
    // A leg hides the places with y above 0.05 for half a second.
    for _ in 0..12 {
        story.look_with(&[], &|[_, y]| y < 0.05);
    }
    assert_eq!(story.own().state, BallState::Remembered);
    let id = story.own().id;
    story.look(&[[0.6, 0.1]]);
    assert!(story.own().state == BallState::Seen && story.own().id == id);
}

#[test]
fn it_keeps_to_its_own_of_two_balls_also_while_only_the_other_is_seen() {
    let mut story = Story::new();
    for _ in 0..5 {
        story.look(&[[1.0, 0.0]]);
    }
    let id = story.own().id;
    for _ in 0..20 {
        assert_eq!(story.look(&[[1.5, 0.6], [1.0, 0.0]]), Some(1));
    }
    for _ in 0..50 {
        // The ball to kick is hidden, the other one is not.
        assert_eq!(story.look_with(&[[1.5, 0.6]], &|[x, _]| x > 1.2), None);
    }
    let own = story.own();
    assert!(own.id == id && own.state == BallState::Remembered && story.is_near([1.0, 0.0], 0.03), "{own:?}");
    assert_eq!(story.memory.all(&story.rolling).len(), 2);
    // Somebody takes it away: now the other one will do.
    for _ in 0..15 {
        story.look(&[[1.5, 0.6]]);
    }
    assert!(story.own().id != id && story.is_near([1.5, 0.6], 0.03));
}

#[test]
fn false_detections_do_not_move_it() {
    let mut story = Story::new();
    for _ in 0..10 {
        story.look(&[[1.2, -0.2]]);
    }
    for k in 0..30 {
        let wrong = [0.4 + 0.11 * f64::from(k % 7), 0.5];
        // The ball is missed in every third image, and something else is found in every second one.
        let mut finds = Vec::new();
        if k % 2 == 0 {
            finds.push(wrong);
        }
        if k % 3 != 0 {
            finds.push([1.2, -0.2]);
        }
        story.look(&finds);
    }
    assert!(story.own().state == BallState::Seen && story.is_near([1.2, -0.2], 0.02));
}

#[test]
fn a_rolling_ball_is_where_it_has_rolled_to_while_unseen() {
    let mut story = Story::new();
    let at = |time_s: f64| [1.5 - 0.3 * (time_s - AGE_S), 0.4];
    for _ in 0..40 {
        story.look(&[at(story.time_s + STEP_S)]);
    }
    let velocity = story.own().belief.ball.velocity;
    assert!((velocity[0] + 0.3).abs() < 0.02 && velocity[1].abs() < 0.02, "{velocity:?}");
    for _ in 0..12 {
        story.look_with(&[], &|_| false);
    }
    let now = 1.5 - 0.3 * story.time_s;
    let own = story.own();
    assert!(own.state == BallState::Remembered && story.is_near([now, 0.4], 0.03), "{own:?}");
}

#[test]
fn a_kicked_ball_is_followed_and_is_the_same_ball() {
    let mut story = Story::new();
    story.rolling.to_strike_s = 20.0 * STEP_S;
    for _ in 0..20 {
        story.look(&[[0.7, 0.0]]);
    }
    let id = story.own().id;
    // It is struck now and goes off at 4 m/s. Images are 0.06 s old.
    let struck_s = story.time_s;
    for _ in 0..10 {
        let flown = (story.time_s + STEP_S - AGE_S - struck_s).max(0.0);
        story.look(&[[0.7 + 4.0 * flown, 0.0]]);
    }
    let own = story.own();
    assert_eq!((own.id, own.state), (id, BallState::Seen));
    let now = 0.7 + 4.0 * (story.time_s - struck_s);
    assert!(story.is_near([now, 0.0], 0.1), "{:?} at {now}", own.belief.ball.position);
}

#[test]
fn constants_that_make_no_sense_are_refused_by_key() {
    assert!(MemoryPreset::default().check().is_ok());
    let error = MemoryPreset { missed_factor: 1.5, ..MemoryPreset::default() }.check().expect_err("a share");
    assert_eq!(error.to_string(), "missed_factor is 1.5, expected above 0 and at most 1");
    assert!(MemoryPreset { confirm: 0, ..MemoryPreset::default() }.check().is_err());
}
