//! Collects and judges errors.

/// What a quantity's errors may be. `None`: reported only.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limit {
    /// Limit of the median.
    pub median: Option<f64>,
    /// Limit of the 99th percentile.
    pub p99: Option<f64>,
    /// Limit of the maximum.
    pub max: Option<f64>,
}

impl Limit {
    /// A limit on the maximum alone.
    pub fn max(max: f64) -> Self {
        Self {
            max: Some(max),
            ..Self::default()
        }
    }
}

/// Errors of one quantity over a file.
#[derive(Debug)]
pub struct Quantity {
    /// What, with its unit.
    pub name: &'static str,
    limit: Limit,
    errors: Vec<f64>,
    /// Rows where the library gave no finite value though there is one.
    pub nonfinite: usize,
    /// Line of the largest error.
    pub worst_line: usize,
    worst: f64,
}

impl Quantity {
    /// Rows that count.
    pub fn rows(&self) -> usize {
        self.errors.len() + self.nonfinite
    }

    /// The error that a share of the rows does not exceed; 0 without rows.
    pub fn quantile(&self, share: f64) -> f64 {
        let mut sorted = self.errors.clone();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        sorted
            .get(((last as f64) * share).ceil() as usize)
            .copied()
            .unwrap_or(0.0)
    }

    /// All limits hold and nothing is missing.
    pub fn passes(&self) -> bool {
        let holds =
            |limit: Option<f64>, share| limit.is_none_or(|limit| self.quantile(share) <= limit);
        self.nonfinite == 0
            && holds(self.limit.median, 0.5)
            && holds(self.limit.p99, 0.99)
            && holds(self.limit.max, 1.0)
    }

    /// The limits in words.
    pub fn limits(&self) -> String {
        let Limit { median, p99, max } = self.limit;
        let parts = [("median", median), ("p99", p99), ("max", max)];
        let words: Vec<_> = parts
            .iter()
            .filter_map(|(n, l)| l.map(|l| format!("{n}<={l:.0e}")))
            .collect();
        words.join(" ")
    }
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            out,
            "{:<50} {:>5} rows  median {:>8.1e}  99 % {:>8.1e}  max {:>8.1e} (line {})  not finite {}  [{}] {}",
            self.name,
            self.rows(),
            self.quantile(0.5),
            self.quantile(0.99),
            self.quantile(1.0),
            self.worst_line,
            self.nonfinite,
            self.limits(),
            if self.passes() { "" } else { "FAIL" },
        )
    }
}

/// What the library made of one file.
#[derive(Debug)]
pub struct FileReport {
    /// File name.
    pub file: String,
    /// Rows evaluated.
    pub rows: usize,
    /// Errors by quantity.
    pub quantities: Vec<Quantity>,
    /// Rows where the library decides otherwise than the reference: line and both decisions.
    pub misclassified: Vec<(usize, String)>,
}

impl FileReport {
    pub(super) fn new(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            rows: 0,
            quantities: Vec::new(),
            misclassified: Vec::new(),
        }
    }

    /// Every limit holds, nothing is missing or misclassified, and there was something to judge.
    pub fn passes(&self) -> bool {
        self.rows > 0
            && self.misclassified.is_empty()
            && self.quantities.iter().all(Quantity::passes)
    }

    /// Adds a quantity; its errors follow by [`FileReport::note`].
    pub(super) fn quantity(&mut self, name: &'static str, limit: Limit) {
        let quantity = Quantity {
            name,
            limit,
            errors: Vec::new(),
            nonfinite: 0,
            worst_line: 0,
            worst: -1.0,
        };
        self.quantities.push(quantity);
    }

    /// Notes an error of a quantity added before; one that is not finite counts as a missing value.
    pub(super) fn note(&mut self, name: &'static str, line: usize, error: f64) {
        let Some(quantity) = self.quantities.iter_mut().find(|q| q.name == name) else {
            panic!("quantity {name} was not added");
        };
        if !error.is_finite() {
            quantity.nonfinite += 1;
            quantity.worst_line = line;
            return;
        }
        if error > quantity.worst && quantity.nonfinite == 0 {
            quantity.worst = error;
            quantity.worst_line = line;
        }
        quantity.errors.push(error);
    }

    pub(super) fn misclassify(&mut self, line: usize, what: String) {
        self.misclassified.push((line, what));
    }
}
