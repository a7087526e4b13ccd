//! From a tree of loops to the points of a path.

use super::{
    fermat_spiral::spiral,
    graph::{Isograph, StationId},
    loop_tree::LoopTree,
    selector::Selection,
    ways::Ways,
};
use terrain::Point;

/// A closed path over stations.
#[derive(Debug, Clone)]
pub(super) struct ClosedPath {
    pub(super) stations: Vec<StationId>,
}

impl ClosedPath {
    /// Stitches the loops; what cannot be stitched is driven to, and back, on the shortest way.
    pub(super) fn new(graph: &Isograph, ways: &Ways<'_>, tree: &LoopTree, selection: &mut Selection) -> Self {
        let spiral = spiral(graph, tree, selection);
        let ring = spiral.weave.ring(tree.loops[tree.root].ring[0]);
        // A station that a way passes is not yet driven around.
        let mut driven = vec![false; graph.station_count()];
        let mut mark = |ring: &[StationId]| {
            let is_new = !driven[ring[0] as usize];
            for &station in ring {
                driven[station as usize] = true;
            }
            is_new
        };
        mark(&ring);
        let mut path = Self { stations: ring };
        for apart in spiral.apart {
            let ring = spiral.weave.ring(tree.loops[apart].ring[0]);
            if mark(&ring) {
                path.detour(ways, &ring);
            }
        }
        path
    }

    /// Inserts a closed line with the way there and back. A line that no way leads to is left out.
    fn detour(&mut self, ways: &Ways<'_>, ring: &[StationId]) {
        let way = ways.shortest(self.stations.iter().copied(), |station| ring.contains(&station));
        let Some(way) = way else { return };
        let (leave, arrive) = (way[0], way[way.len() - 1]);
        let mut detour = way.clone();
        let place = ring.iter().position(|&station| station == arrive).expect("the way ends on the ring");
        detour.extend(ring[place + 1..].iter().chain(&ring[..place]));
        detour.extend(way.iter().rev());
        let at =
            self.stations.iter().position(|&station| station == leave).expect("the way begins on the path");
        self.stations.splice(at..=at, detour);
    }

    /// The points, the first repeated at the end.
    pub(super) fn points(&self, graph: &Isograph) -> Vec<Point> {
        let closed: Vec<StationId> = self.stations.iter().chain(self.stations.first()).copied().collect();
        graph.points_along(&closed)
    }

    pub(super) fn length_m(&self, graph: &Isograph) -> f64 {
        self.points(graph).windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }
}
