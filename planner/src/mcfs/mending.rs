//! Moves joints within a line to where they cost least: what evening out leaves is seldom there.
//!
//! A joint is taken out: the line falls in two, and tracks that it parted are whole again. Then the two parts are
//! joined where that costs least. Way and turning become less, and every robot keeps its places.

use super::sharing::{Share, Sharing};
use super::web::Exchange;
use std::collections::BTreeSet;

/// The most joints that are moved in one line.
const MENDINGS: usize = 40;
/// Taking a joint out must save so many tool widths to be tried, and moving it so many.
const OPENED: f64 = 0.5;
const MOVED: f64 = 0.1;

impl Sharing<'_> {
    /// Moves the joints within each line.
    pub(super) fn mend_joints(&mut self, shares: &mut [Share]) {
        for share in shares {
            for _ in 0..MENDINGS {
                let Some(line) = self.mended(&share.line) else { break };
                share.line = line;
            }
        }
    }

    /// The line with one joint taken out and the two parts joined more cheaply.
    fn mended(&mut self, line: &[u32]) -> Option<Vec<u32>> {
        self.openings(line).into_iter().find_map(|(value_m, opening)| self.moved(line, value_m, opening))
    }

    /// The joint at an opening moved elsewhere, if that pays.
    fn moved(&mut self, line: &[u32], opened_m: f64, opening: Exchange) -> Option<Vec<u32>> {
        self.web.apply(opening);
        let mut parts = [opening.one.0, opening.one.1].map(|place| self.web.closed_line(place));
        parts.sort_by_key(Vec::len);
        let [shorter, longer] = &parts;
        if shorter.len() > 2 && longer.len() < line.len() {
            let join = self.best_join(shorter, longer);
            if let Some(join) = join.filter(|&join| opened_m + self.value_m(join) < -MOVED * self.web.width_m)
            {
                self.web.apply(join);
                return Some(self.web.closed_line(join.one.0));
            }
        }
        self.web.apply(opening.undone());
        None
    }

    /// Exchanges that link places again which a joint parted, and what they cost; the cheapest first.
    fn openings(&self, line: &[u32]) -> Vec<(f64, Exchange)> {
        let mut position = vec![usize::MAX; self.web.len()];
        line.iter().enumerate().for_each(|(at, &place)| position[place as usize] = at);
        let on_line = |&place: &u32| position[place as usize] != usize::MAX;
        let mut seen = BTreeSet::new();
        let mut openings = Vec::new();
        for &place in line {
            for beside in self.web.parted(place).filter(on_line) {
                let [one, other] = [place, beside].map(|place| position[place as usize]);
                for exchange in relinking(line, one, other) {
                    if seen.insert(ends(exchange)) {
                        openings.push((self.value_m(exchange), exchange));
                    }
                }
            }
        }
        openings.retain(|&(value_m, exchange)| {
            value_m < -OPENED * self.web.width_m && self.web.allows(exchange, self.walls)
        });
        openings.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        openings
    }

    fn value_m(&self, exchange: Exchange) -> f64 {
        self.web.cost(exchange).value_m(self.web.width_m)
    }
}

/// The two exchanges that link two positions of a line and part it in two.
fn relinking(line: &[u32], one: usize, other: usize) -> impl Iterator<Item = Exchange> {
    let count = line.len();
    let ahead = |at: usize| line[(at + 1) % count];
    let behind = |at: usize| line[(at + count - 1) % count];
    let pairs = [(ahead(one), behind(other)), (behind(one), ahead(other))];
    let (a, b) = (line[one], line[other]);
    let is_sound = move |&(a2, b2): &(u32, u32)| a2 != b && b2 != a && a2 != b2;
    pairs.into_iter().filter(is_sound).map(move |(a2, b2)| Exchange { one: (a, a2), other: (b, b2) })
}

fn ends(exchange: Exchange) -> [u32; 4] {
    let mut ends = [exchange.one.0, exchange.one.1, exchange.other.0, exchange.other.1];
    ends.sort_unstable();
    ends
}
