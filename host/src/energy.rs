//! Energy ledger of frames: the fate of the light paths' flux.

use caustics_kernels::interface::ledger::{Entry, LEDGER_BANKS, slot};

/// Flux by fate, summed over channels (W). Up to sampling noise, the emitted flux is the sum of all others.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct EnergyLedger {
    /// Emitted by the lights.
    pub emitted: f64,
    /// Absorbed by surfaces and media.
    pub absorbed: f64,
    /// Escaped from the scene.
    pub escaped: f64,
    /// Carried by paths at the maximum path length.
    pub cut: f64,
    /// Lost (negative: gained) where shading normals differ from face normals.
    pub shading_normals: f64,
    /// Scattered at a first surface by lobes whose light belongs to the camera paths.
    pub left_to_camera: f64,
    /// (emitted - all others) / emitted; 0 where nothing was emitted.
    pub residual: f64,
}

impl EnergyLedger {
    /// Reads the ledger from the words of the buffer `counters`. `quantum` is the quantum of the accumulator.
    pub fn from_words(words: &[u32], quantum: f32) -> EnergyLedger {
        let sum = |entry| -> f64 {
            let banks = (0..LEDGER_BANKS).map(|bank| {
                let first = slot(entry, bank) as usize;
                (u64::from(words[first + 1]) << 32 | u64::from(words[first])) as i64
            });
            banks.map(i128::from).sum::<i128>() as f64 * f64::from(quantum)
        };
        EnergyLedger {
            emitted: sum(Entry::Emitted),
            absorbed: sum(Entry::Absorbed),
            escaped: sum(Entry::Escaped),
            cut: sum(Entry::Cut),
            shading_normals: sum(Entry::ShadingNormals),
            left_to_camera: sum(Entry::LeftToCamera),
            residual: 0.0,
        }
        .balanced()
    }

    /// Returns the sum of two ledgers.
    pub fn plus(self, other: EnergyLedger) -> EnergyLedger {
        EnergyLedger {
            emitted: self.emitted + other.emitted,
            absorbed: self.absorbed + other.absorbed,
            escaped: self.escaped + other.escaped,
            cut: self.cut + other.cut,
            shading_normals: self.shading_normals + other.shading_normals,
            left_to_camera: self.left_to_camera + other.left_to_camera,
            residual: 0.0,
        }
        .balanced()
    }

    /// Returns the ledger with all flux multiplied by a factor.
    pub fn times(self, scale: f64) -> EnergyLedger {
        EnergyLedger {
            emitted: self.emitted * scale,
            absorbed: self.absorbed * scale,
            escaped: self.escaped * scale,
            cut: self.cut * scale,
            shading_normals: self.shading_normals * scale,
            left_to_camera: self.left_to_camera * scale,
            residual: self.residual,
        }
    }

    fn balanced(self) -> EnergyLedger {
        let spent = self.absorbed + self.escaped + self.cut + self.shading_normals + self.left_to_camera;
        let rest = self.emitted - spent;
        let residual = if self.emitted > 0.0 { rest / self.emitted } else { 0.0 };
        EnergyLedger { residual, ..self }
    }
}
