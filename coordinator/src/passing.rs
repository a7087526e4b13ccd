//! Driving through passages: from the cells of a way to the places of a route, on to a passage, and off it again from
//! wherever a robot stands on it.
//!
//! ```text
//!   cells of a way    A      B                 a move where the lattice has one, else the passage that joins them
//!   places            A ───╮ ╭─── B
//!                          ╰●╯                 ● stopped here, with no cell beside it: its start cell is the end of
//!                                                the passage that it comes to first, and the bends up to there come first
//! ```

use crate::{Coordinator, ledger::RobotIndex, route::Waypoint};
use terrain::{Cell, Passage, Point, Segment};

/// What a robot beside its line may lack of the room that routes have, metres.
const SLACK_M: f64 = 0.02;

impl Coordinator {
    /// The places of a way, its first cell left out; the tool is on where something is left to sweep.
    pub(crate) fn places(&self, way: &[Cell]) -> Vec<Waypoint> {
        let mut places = Vec::new();
        for pair in way.windows(2) {
            match self.passage(pair[0], pair[1]) {
                Some(passage) => places.extend(self.places_along(passage.points[0], &passage.points[1..])),
                None => places.push(self.place(pair[1])),
            }
        }
        places
    }

    /// The places of a way that begins in a robot's start cell, from the end of its base on.
    pub(crate) fn places_from_base(&self, index: RobotIndex, way: &[Cell]) -> Vec<Waypoint> {
        let (Some(end), Some(&first)) = (self.robots[index].route.base_end(), way.first()) else {
            return Vec::new();
        };
        let mut places = self.places_along(end.point, &self.bends_to(end.point, first));
        if end.cell.is_none() {
            places.push(self.place(first));
        }
        places.extend(self.places(way));
        places
    }

    /// A way as points, metres.
    pub(crate) fn points_along(&self, way: &[Cell]) -> Vec<Point> {
        let center = |&cell: &Cell| self.floor.lattice().center(cell);
        let mut points: Vec<Point> = way.first().map(center).into_iter().collect();
        for pair in way.windows(2) {
            match self.passage(pair[0], pair[1]) {
                Some(passage) => points.extend(&passage.points[1..]),
                None => points.push(center(&pair[1])),
            }
        }
        points
    }

    /// The passage by which a way gets from a cell to the next one; `None` where that is a move.
    fn passage(&self, from: Cell, to: Cell) -> Option<&Passage> {
        if self.floor.neighbours(from).any(|next| next == to) {
            return None;
        }
        let index = self.floor.lattice().index(from)?;
        self.passages.from(index).find(|passage| passage.to == to)
    }

    /// The open end of a passage on which somebody stands who sees no cell beside him; the nearer one.
    pub(crate) fn end_of_passage(&self, point: Point) -> Option<Cell> {
        let open = self.passages.iter().filter(|passage| self.is_open_ground(passage.to));
        let ends = open.filter_map(|passage| Some((length_m(&self.rest_of(passage, point)?), passage.to)));
        ends.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, cell)| cell)
    }

    /// The bends on the way from a place to the centre of a robot's start cell: none where the straight way is free, else
    /// those of the passage that the place is on.
    pub(crate) fn bends_to(&self, point: Point, cell: Cell) -> Vec<Point> {
        if self.is_free(Segment::new(point, self.floor.lattice().center(cell))) {
            return Vec::new();
        }
        let rests = self.passages.iter().filter(|passage| passage.to == cell);
        let rest = rests
            .filter_map(|passage| self.rest_of(passage, point))
            .min_by(|a, b| length_m(a).total_cmp(&length_m(b)));
        rest.map_or_else(Vec::new, |rest| rest[1..rest.len() - 1].to_vec())
    }

    /// What of a passage lies before somebody who stands on it or near it, from his place to the end.
    fn rest_of(&self, passage: &Passage, point: Point) -> Option<Vec<Point>> {
        let near_m = self.floor.lattice().cell_m;
        let pieces = passage.points.windows(2).map(|pair| Segment::new(pair[0], pair[1]));
        let reached = pieces.enumerate().map(|(at, piece)| (at, piece.nearest(point)));
        let (at, nearest) = reached
            .filter(|&(_, place)| (place - point).norm() < near_m && self.is_free(Segment::new(point, place)))
            .min_by(|a, b| (a.1 - point).norm().total_cmp(&(b.1 - point).norm()))?;
        Some([&[point, nearest], &passage.points[at + 1..]].concat())
    }

    fn is_free(&self, segment: Segment) -> bool {
        let mission = &self.config.mission;
        mission.map.capsule_is_free(segment, mission.body_radius_m - SLACK_M)
    }
}

fn length_m(points: &[Point]) -> f64 {
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}
