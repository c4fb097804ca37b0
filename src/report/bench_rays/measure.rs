//! Timing one set in one configuration.

use super::files::RaySet;
use super::{SetReport, TraceMode};
use crate::accel::{Accel, Brute, Mode, Packet, Shadow, Single, Stream};
use crate::geometry::{Hit, MISS, Ray};
use crate::lane::{Bits, Mask, Real, Vec3, f32x8, f32x16, prefetch_second};
use crate::process::{allowed_cores, pin_to_core, thread_cpu_seconds};
use std::panic::resume_unwind;
use std::sync::{Barrier, Mutex};
use std::time::Instant;

/// Rays a thread takes at a time.
const CHUNK: usize = 4096;

/// What a pass writes: t (closest hits only) and the primitive, or 0 for any hit.
struct Output {
    t: Vec<f32>,
    primitive: Vec<u32>,
}

type Pass = fn(&Accel, &RaySet, usize, &mut [f32], &mut [u32]);

#[allow(clippy::too_many_arguments)] // the axes of a table; a struct would only rename them
pub fn measure(
    accel: &Accel,
    name: &str,
    rays: &RaySet,
    mode: TraceMode,
    lanes: usize,
    threads: usize,
    windows: usize,
    scale: f32,
) -> SetReport {
    let pass = pass(mode, lanes);
    let mut out = Output { t: vec![0.0; rays.count()], primitive: vec![MISS; rays.count()] };
    run(accel, rays, pass, threads, &mut out);
    let passes: Vec<Pace> = (0..windows).map(|_| run(accel, rays, pass, threads, &mut out)).collect();
    let rates = |seconds: fn(&Pace) -> f64| {
        let mut rates: Vec<f64> = passes.iter().map(|p| rays.count() as f64 * 1e-6 / seconds(p)).collect();
        rates.sort_by(f64::total_cmp);
        rates
    };
    let (cpu, rates) = (rates(|p| p.cpu), rates(|p| p.wall));
    let hit = |i: &usize| out.primitive[*i] != MISS;
    let hits = (0..rays.count()).filter(hit);
    let sum_t = hits.clone().filter(|_| !rays.any).map(|i| f64::from(out.t[i]) / f64::from(scale)).sum::<f64>() + 0.0;
    SetReport {
        set: name.into(),
        threads,
        lanes,
        mode,
        mrays_per_s: rates[rates.len() / 2],
        min: rates[0],
        max: rates[rates.len() - 1],
        mrays_per_cpu_s: cpu[cpu.len() / 2],
        hits: hits.count(),
        rays: rays.count(),
        sum_t,
    }
}

fn pass(mode: TraceMode, lanes: usize) -> Pass {
    fn at<M: Mode>(lanes: usize) -> Pass {
        match lanes {
            1 => trace_chunk::<f32, M>,
            8 => trace_chunk::<f32x8, M>,
            _ => trace_chunk::<f32x16, M>,
        }
    }
    match mode {
        TraceMode::Brute => at::<Brute>(lanes),
        TraceMode::Packet => at::<Packet>(lanes),
        TraceMode::Shadow => at::<Shadow>(lanes),
        TraceMode::Stream => at::<Stream>(lanes),
        TraceMode::Single | TraceMode::Auto => at::<Single>(lanes),
    }
}

/// Seconds of one pass: on the clock, from the moment all threads are pinned and ready, and summed over processors.
struct Pace {
    wall: f64,
    cpu: f64,
}

/// One pass over the whole set.
fn run(accel: &Accel, rays: &RaySet, pass: Pass, threads: usize, out: &mut Output) -> Pace {
    let chunks = out.t.chunks_mut(CHUNK).zip(out.primitive.chunks_mut(CHUNK)).enumerate();
    let (work, ready) = (Mutex::new(chunks), Barrier::new(threads + 1));
    let cores = allowed_cores();
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|cpu| {
                let (work, ready, cores) = (&work, &ready, &cores);
                scope.spawn(move || {
                    if let Some(&core) = cores.get(cpu % cores.len().max(1)) {
                        pin_to_core(core);
                    }
                    ready.wait();
                    let (start, before) = (Instant::now(), thread_cpu_seconds());
                    // A panic elsewhere poisons nothing that matters: the chunks are independent.
                    let take = || work.lock().unwrap_or_else(|e| e.into_inner()).next();
                    while let Some((i, (t, primitive))) = take() {
                        pass(accel, rays, i * CHUNK, t, primitive);
                    }
                    (start, Instant::now(), thread_cpu_seconds() - before)
                })
            })
            .collect();
        ready.wait();
        // A worker that fell must not pass for one that was fast.
        let join = |worker: std::thread::ScopedJoinHandle<'_, _>| worker.join().unwrap_or_else(|e| resume_unwind(e));
        let done: Vec<_> = workers.into_iter().map(join).collect();
        // By the workers' own clocks: on a busy machine this thread may wake after they have finished.
        let start = done.iter().map(|d| d.0).min();
        let end = done.iter().map(|d| d.1).max();
        let wall = start.zip(end).map_or(0.0, |(start, end)| end.duration_since(start).as_secs_f64());
        Pace { wall: wall.max(1e-9), cpu: done.iter().map(|d| d.2).sum::<f64>().max(1e-9) }
    })
}

/// Packets given to a mode at a time.
const PACKETS: usize = 16;

fn trace_chunk<R: Real, M: Mode>(accel: &Accel, rays: &RaySet, first: usize, t: &mut [f32], primitive: &mut [u32]) {
    let all = [R::Mask::splat(true); PACKETS];
    let packet = |at: usize| {
        let column = |c: usize| R::load(&rays.columns[c][at..]);
        Ray::new(Vec3::new(column(0), column(1), column(2)), Vec3::new(column(3), column(4), column(5)), column(6))
    };
    let mut packets = [packet(first); PACKETS];
    let (mut hits, mut found) = ([Hit::miss(R::zero()); PACKETS], all);
    for k in (0..t.len()).step_by(R::WIDTH * PACKETS) {
        let count = PACKETS.min((t.len() - k) / R::WIDTH);
        for (i, packet_at) in packets[..count].iter_mut().enumerate() {
            *packet_at = packet(first + k + i * R::WIDTH);
        }
        // What is timed is not how long these rays take to come from memory: the next ones' come meanwhile.
        for column in &rays.columns {
            for line in (0..R::WIDTH * PACKETS).step_by(16) {
                prefetch_second(column.as_ptr().wrapping_add(first + k + R::WIDTH * PACKETS + line));
            }
        }
        if rays.any {
            accel.occluded_many::<R, M>(&packets[..count], &all[..count], &mut found[..count]);
            for (i, hit) in found[..count].iter().enumerate() {
                let word = R::Bits::select(*hit, R::Bits::splat(0), R::Bits::splat(MISS));
                word.store(&mut primitive[k + i * R::WIDTH..]);
            }
        } else {
            accel.trace_many::<R, M>(&packets[..count], &all[..count], &mut hits[..count]);
            for (i, hit) in hits[..count].iter().enumerate() {
                hit.t.store(&mut t[k + i * R::WIDTH..]);
                hit.primitive.store(&mut primitive[k + i * R::WIDTH..]);
            }
        }
    }
}
