//! One random stream per purpose and entity, keyed by the seed: taking one fault or robot away does not shift
//! what the others draw.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The stream of `entity` for `purpose` under a seed.
pub(crate) fn stream(seed: u64, purpose: &str, entity: &str) -> ChaCha8Rng {
    let mut key = [0; 32];
    let mut state = seed ^ 0x6f78_706c_6f77_0001;
    for text in [purpose, entity] {
        for byte in text.bytes().chain([0xff]) {
            state = scramble(state ^ u64::from(byte));
        }
    }
    for chunk in key.chunks_exact_mut(8) {
        state = scramble(state);
        chunk.copy_from_slice(&state.to_le_bytes());
    }
    ChaCha8Rng::from_seed(key)
}

fn scramble(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Bell-shaped noise of standard deviation `sigma` that never exceeds 2.3 of it.
pub(crate) fn bounded_noise(rng: &mut ChaCha8Rng, sigma: f64) -> f64 {
    let bits: u64 = rng.random();
    let quarters = (0..4).map(|part| f64::from((bits >> (16 * part)) as u16) / 65_535.0 - 0.5);
    // Four uniform draws: standard deviation 1/√3, never more than 2.
    let sum: f64 = quarters.sum();
    (sum * 3.0_f64.sqrt()).clamp(-2.3, 2.3) * sigma
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_seed_purpose_and_entity_and_repeat() {
        let draw = |seed, purpose, entity| stream(seed, purpose, entity).random::<u64>();
        assert_eq!(draw(1, "fix", "r1"), draw(1, "fix", "r1"));
        assert_ne!(draw(1, "fix", "r1"), draw(2, "fix", "r1"));
        assert_ne!(draw(1, "fix", "r1"), draw(1, "fix", "r2"));
        assert_ne!(draw(1, "fix", "r1"), draw(1, "odometry", "r1"));
    }

    #[test]
    fn noise_has_its_deviation_and_keeps_its_bound() {
        let mut rng = stream(7, "noise", "");
        let draws: Vec<f64> = (0..20_000).map(|_| bounded_noise(&mut rng, 0.003)).collect();
        let deviation = (draws.iter().map(|x| x * x).sum::<f64>() / draws.len() as f64).sqrt();
        assert!((0.0028..0.0031).contains(&deviation), "{deviation}");
        assert!(draws.iter().all(|x| x.abs() <= 0.0069 + 1e-12));
    }
}
