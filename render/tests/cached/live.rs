//! The live view: where it comes to rest, its picture is that of `render image`.

use crate::common::{compare, table, world};
use render::film::render;
use render::image::Image;
use render::image::view::View;
use render::integrator::PathTracer;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Caches, Interpolation, Settings, render_cached};
use render::live::{Answer, Audience, Command, Desk, Engine, Frame, Navigator, Options, Session, Stage};
use render::picture::{Budget, Picture};
use render::scene::FovAxis;
use render::walk::read_rows;
use render::world::World;
use std::collections::VecDeque;

const TAU: f32 = 0.3;
const SPP: u32 = 6;

fn settings() -> Settings {
    Settings { tolerance: Some(TAU), budget: Budget::Samples(SPP), ..crate::common::settings() }
}

fn policy(world: &World) -> Policy {
    Policy::new(&world.scene, Allowed::Auto, |r| Ok::<_, ()>(table(r))).expect("tables fit")
}

/// Gives the next orders whenever the picture is there, and keeps it.
struct Script<'a> {
    desk: &'a Desk,
    orders: VecDeque<Vec<Command>>,
    settled: Vec<Picture>,
    answers: Vec<Answer>,
    stages: Vec<Stage>,
}

impl Audience for Script<'_> {
    fn show(&mut self, frame: Frame) {
        self.stages.push(frame.status.stage);
        let Some(picture) = frame.picture else { return };
        let jpeg = frame.jpeg.expect("every picture is shown");
        assert!(jpeg.starts_with(&[0xff, 0xd8]) && jpeg.ends_with(&[0xff, 0xd9]));
        assert_eq!(frame.status.size, [picture.width, picture.height]);
        if frame.status.stage == Stage::Settled {
            self.settled.push(picture.clone());
            match self.orders.pop_front() {
                Some(orders) => orders.into_iter().for_each(|order| self.desk.tell(order)),
                None => self.desk.leave(),
            }
        }
    }

    fn tell(&mut self, answer: Answer) {
        self.answers.push(answer);
    }
}

/// Runs a view until all orders are followed.
fn run(world: &World, orders: Vec<Vec<Command>>) -> (Vec<Picture>, Vec<Answer>, Vec<Stage>, Caches) {
    let desk = Desk::default();
    let engine = |name: &str, cached| Engine { name: name.into(), cached };
    let options = Options {
        engines: vec![engine("auto", true), engine("path", false)],
        engine: 0,
        settings: settings(),
        tolerance: TAU,
        spp: SPP,
        stops: 0.0,
        view: View::Agx,
        denoiser: None,
        denoise: false,
        fov: (FovAxis::X, 1.0),
        most_bytes: 1 << 30,
    };
    let mut script =
        Script { desk: &desk, orders: orders.into(), settled: Vec::new(), answers: Vec::new(), stages: Vec::new() };
    let mut prepare = |_: &Engine, _: f32| Ok(policy(world));
    let caches = Session::new(world, options, None, &desk, &mut prepare, &mut script).run();
    (script.settled, script.answers, script.stages, caches.expect("the first method has records"))
}

fn same(a: &Image, b: &Image) -> bool {
    a.pixels.len() == b.pixels.len()
        && a.pixels.iter().zip(&b.pixels).all(|(a, b)| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * (a + b)))
}

/// Records made bit by bit, with frames in between, are those of one fill; the picture is refined to that of the same samples. What was
/// left for another method is there again, and a view that moved agrees with its picture within the error of records.
#[test]
fn a_view_comes_to_rest_at_the_picture_of_render_image() {
    let mut world = world("cornell-glossy.xml", &[("width", "32"), ("height", "32")]);
    let name = |name: &str| Command::Method { name: name.into() };
    let away = [Command::Turn { yaw: 0.1, pitch: -0.05 }, Command::Step { forward: 0.3, right: 0.2, up: 0.1 }];
    let splat = Command::Interpolation { name: Interpolation::Splat };
    let orders = vec![vec![name("path")], vec![name("auto")], vec![splat], away.to_vec(), vec![Command::Home {}]];
    let (pictures, _, stages, caches) = run(&world, orders);
    let [first, path, again, drawn, moved, home] = &pictures[..] else { panic!("{} pictures", pictures.len()) };

    let policy = policy(&world);
    let (expected, _, filled) = render_cached(&world, &policy, &settings(), None, &|_| ());
    assert!(first.image() == expected.image(), "the same records, samples and sums");
    assert!(again.image() == expected.image());
    assert!(drawn.image() == expected.image(), "the same records, drawn onto the pixels");
    assert!(caches.records() > filled.records(), "the view that moved got its own");

    let tracer = PathTracer { settings: world.scene.integrator, indirect_only: false };
    let traced = render(&world, &tracer, Budget::Samples(SPP), settings().seed, &|_| ());
    assert!(same(&path.image(), &traced.image()));

    let (error, bias) = compare(home, &expected);
    assert!(error < 5e-3 && bias.abs() < 0.02, "{error} {bias}");
    let (low, high) = world.bounds();
    let mut navigator = Navigator::new(&world.scene.camera, [low.as_dvec3(), high.as_dvec3()], 1.0);
    navigator.turn(0.1, -0.05);
    assert_ne!(navigator.camera(), &world.scene.camera);
    let (error, _) = compare(moved, &expected);
    assert!(error > 5e-3, "the camera has moved: {error}");
    assert!([Stage::Preparing, Stage::Moving, Stage::Settled].iter().all(|stage| stages.contains(stage)));

    // The view that moved, from nothing but its own camera.
    let row = {
        let (_, answers, ..) =
            run(&world, vec![away.to_vec(), vec![Command::Mark {}, Command::Exposure { stops: 1.0 }]]);
        let Some(Answer::View { csv }) = answers.first() else { panic!("{answers:?}") };
        read_rows(csv.as_bytes()).unwrap()[&1]
    };
    let rows = [(1, row)].into_iter().collect();
    let walk = render::walk::Walk::through(&rows, &world.scene.camera, FovAxis::X, 1.0).unwrap();
    world.scene.camera = walk.camera(1).unwrap().clone();
    let (expected, ..) = render_cached(&world, &policy, &settings(), None, &|_| ());
    let (error, bias) = compare(moved, &expected);
    assert!(error < 5e-3 && bias.abs() < 0.02, "{error} {bias}");
}

/// A walk is recorded while one goes, and what only changes the look of a picture draws it anew without a sample more.
#[test]
fn walks_are_recorded() {
    let world = world("cornell-glossy.xml", &[("width", "16"), ("height", "16")]);
    let step = || vec![Command::Step { forward: 0.1, right: 0.0, up: 0.0 }];
    let marks = Command::Marks { dots: true, zones: true };
    let orders = vec![
        vec![Command::Record { on: true }],
        step(),
        step(),
        vec![Command::Record { on: false }],
        vec![marks, Command::Hurry { factor: 2.0 }],
        vec![Command::View { name: render::live::Shown::Filmic }],
    ];
    let (pictures, answers, ..) = run(&world, orders);
    assert_eq!(pictures.len(), 7);
    let [Answer::Walk { csv, rows }] = &answers[..] else { panic!("{answers:?}") };
    let path = read_rows(csv.as_bytes()).unwrap();
    assert_eq!((path.len(), path.keys().min()), (*rows, Some(&1)));
    let eyes: Vec<_> = path.values().map(|row| row.eye).collect();
    assert_eq!(eyes[0], world.scene.camera.to_world.translation.as_dvec3());
    assert!(pictures[4..].iter().all(|picture| picture.image() == pictures[3].image()));
}

/// Where records may take no more room, the view goes on without more of them.
#[test]
fn full_caches_do_not_grow() {
    let world = world("cornell-glossy.xml", &[("width", "16"), ("height", "16")]);
    let desk = Desk::default();
    let options = Options {
        engines: vec![Engine { name: "auto".into(), cached: true }],
        engine: 0,
        settings: settings(),
        tolerance: TAU,
        spp: 1,
        stops: 0.0,
        view: View::Standard,
        denoiser: None,
        denoise: false,
        fov: (FovAxis::X, 1.0),
        most_bytes: 0,
    };
    struct Once<'a>(&'a Desk, Option<String>);
    impl Audience for Once<'_> {
        fn show(&mut self, frame: Frame) {
            if frame.status.stage == Stage::Settled {
                self.1.clone_from(&frame.status.message);
                self.0.leave();
            }
        }
        fn tell(&mut self, _: Answer) {}
    }
    let mut once = Once(&desk, None);
    let mut prepare = |_: &Engine, _: f32| Ok(policy(&world));
    let caches = Session::new(&world, options, None, &desk, &mut prepare, &mut once).run();
    assert_eq!(caches.map(|caches| caches.records()), Some(0));
    assert!(once.1.is_some_and(|message| message.contains("full")));
}
