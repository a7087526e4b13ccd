//! Ways over open ground: as short as the body allows.
//!
//! Places that follow each other along a route mostly see the same next corner of their ways: so the way of the place
//! before is tried first, from its corners on, and taken when it is not longer than steps over the ground.

use super::Homeward;
use crate::{
    configuration_space::ConfigurationSpace,
    transfers::{Field, Transfers},
};
use terrain::{Point, Segment};

/// Distance fields of the stations.
pub(crate) struct OverGround<'s, 'a> {
    space: &'s ConfigurationSpace<'a>,
    transfers: Transfers<'s, 'a>,
    docks: Vec<[(Point, f64); 1]>,
    fields: Vec<Field>,
    /// Per station: the way found last.
    before: Vec<Vec<Point>>,
}

impl<'s, 'a> OverGround<'s, 'a> {
    pub(crate) fn new(space: &'s ConfigurationSpace<'a>) -> Self {
        let instance = space.instance();
        let mut transfers = Transfers::new(space);
        let docks: Vec<[(Point, f64); 1]> =
            instance.stations.iter().map(|station| [(instance.dock(station), 0.0)]).collect();
        let fields = docks.iter().map(|dock| transfers.field(dock)).collect();
        let before = vec![Vec::new(); docks.len()];
        Self { space, transfers, docks, fields, before }
    }

    /// From a place to the last corner of the way before that it sees, and on along that way.
    fn along_before(&self, place: Point, station: usize) -> Option<Vec<Point>> {
        let before = &self.before[station];
        let most_m = self.fields[station].distance_m(self.space.nearest_place(place)?)?;
        let sees = |corner: &usize| self.space.segment_is_free(Segment::new(place, before[*corner]));
        let corner = (1..before.len().min(3)).rev().find(sees)?;
        let way: Vec<Point> = std::iter::once(place).chain(before[corner..].iter().copied()).collect();
        (length_m(&way) <= most_m).then_some(way)
    }
}

impl Homeward for OverGround<'_, '_> {
    fn way(&mut self, place: Point, station: usize) -> Option<Vec<Point>> {
        let dock = self.docks[station][0].0;
        let straight = self.space.segment_is_free(Segment::new(place, dock)).then(|| vec![place, dock]);
        let way = straight.or_else(|| self.along_before(place, station)).or_else(|| {
            let (field, dock) = (&self.fields[station], &self.docks[station]);
            self.transfers.way_to_source(field, dock, place).map(|(_, way)| way.points)
        })?;
        self.before[station].clone_from(&way);
        let mut way = way;
        way.dedup_by(|next, point| (*next - *point).norm() < 1e-9);
        Some(way)
    }
}

fn length_m(points: &[Point]) -> f64 {
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}
