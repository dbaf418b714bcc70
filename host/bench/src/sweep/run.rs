//! A sweep under way: its cells, measured where they are missing.

use super::task::{SweepContext, Task};
use super::turns::measure_group;

impl SweepContext<'_> {
    /// Measures whatever is missing of these tasks. False where it was stopped.
    ///
    /// # Errors
    ///
    /// A frame that fails, a file that cannot be written.
    pub fn measure_all(&self, tasks: &[Task]) -> anyhow::Result<bool> {
        let missing: Vec<&Task> =
            tasks.iter().filter(|task| !task.is_done(self.config, self.results)).collect();
        let is_one = |a: &&Task, b: &&Task| std::ptr::eq(a.part, b.part) && a.cell.runner == b.cell.runner;
        for group in missing.chunk_by(is_one) {
            if !measure_group(self, group)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
