//! How even points are, by counting them in boxes.

/// The least t for which every elementary box of volume 2^(t−k) holds 2^t of the 2^k points: 0 for a (0, k, N)-net.
pub fn quality<const N: usize>(points: &[[u32; N]]) -> u32 {
    let k = points.len().ilog2();
    (0..=k).find(|t| splits::<N>(k - t).iter().all(|splits| fair(points, splits))).expect("all points are in the cube")
}

/// Does each box that so many digits of each number tell apart hold as many points?
fn fair<const N: usize>(points: &[[u32; N]], splits: &[u32; N]) -> bool {
    let digits: u32 = splits.iter().sum();
    let mut count = vec![0u32; 1 << digits];
    for p in points {
        let join = |cell: usize, d: usize| cell << splits[d] | (u64::from(p[d]) >> (32 - splits[d])) as usize;
        count[(0..N).fold(0, join)] += 1;
    }
    count.iter().all(|&n| n as usize == points.len() >> digits)
}

/// All ways to share `digits` among N numbers.
fn splits<const N: usize>(digits: u32) -> Vec<[u32; N]> {
    let mut ways = vec![([0; N], digits)];
    for d in 0..N - 1 {
        let with = |(splits, left): ([u32; N], u32)| {
            (0..=left).map(move |taken| (std::array::from_fn(|k| if k == d { taken } else { splits[k] }), left - taken))
        };
        ways = ways.into_iter().flat_map(with).collect();
    }
    ways.into_iter().map(|(splits, left)| std::array::from_fn(|k| if k == N - 1 { left } else { splits[k] })).collect()
}
