//! What is to be covered, by whom, from where.

use crate::{Battery, EdgeWeights, Station};
use terrain::{Cell, Floor, MotionModel, Point, Segment};
use thiserror::Error;

/// When a robot's time ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// With the last cell covered.
    Cover,
    /// Back at its start.
    CoverAndReturn,
}

/// Where a robot starts. Robots are numbered by their place in [`Instance::starts`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// The drivable cell its route begins in.
    pub cell: Cell,
    /// Where in that cell it stands, if not at the centre: its body must be able to drive straight to the centre.
    pub point: Option<Point>,
    /// Heading, radians; `None` when the first turn is free.
    pub heading_rad: Option<f64>,
    /// Seconds until it can begin (still driving what was released before, charging, …).
    pub available_in_s: f64,
    /// Seconds of operation left in its battery; `None` when it is full. Counts where the instance has a battery.
    pub charge_s: Option<f64>,
}

impl Start {
    /// A robot at rest in a cell, ready now, with no limit.
    pub const fn at(cell: Cell) -> Self {
        Self { cell, point: None, heading_rad: None, available_in_s: 0.0, charge_s: None }
    }
}

/// Any state of a mission that can be planned for. `visit` and `blocked` are row-major by cell of the floor's
/// lattice.
#[derive(Debug, Clone)]
pub struct Instance<'a> {
    /// The floor: where a body can stand and move.
    pub floor: &'a Floor,
    /// Cells whose centre must be passed with the tool on.
    pub visit: Vec<bool>,
    /// Cells that must not be entered now (blockages, quarantine). Those in which a robot starts count as open.
    pub blocked: Vec<bool>,
    /// Where the robots are.
    pub starts: Vec<Start>,
    /// How fast they are.
    pub motion: MotionModel,
    /// When they are done.
    pub mode: Mode,
    /// Chargers.
    pub stations: Vec<Station>,
    /// What a robot can do between two charges; `None` when that is no limit.
    pub battery: Option<Battery>,
    /// Ground that takes longer; `None` when all moves take the same time.
    pub weights: Option<EdgeWeights>,
    /// Share of the area to be swept that a plan must sweep when it leaves the lattice, in [0, 1]. Plans along the
    /// lattice must pass every cell.
    pub coverage_min: f64,
    /// Per robot, what it is driving already: the cells of its route from its start on. Empty when nothing is under
    /// way. A planner's answer is compared with a repair of these.
    pub incumbent: Vec<Vec<Cell>>,
    /// Routes that have lost their robot, in their order.
    pub orphans: Vec<Vec<Cell>>,
    /// The same for routes that leave the lattice: per robot, the points it still has ahead.
    pub incumbent_lines: Vec<Vec<Point>>,
    /// Lines that have lost their robot.
    pub orphan_lines: Vec<Vec<Point>>,
    /// Row-major by cell: samples that are swept already, so that nobody needs to sweep them again (see
    /// [`terrain::SweptRaster`]). Empty when nothing is. Counts for plans that leave the lattice.
    pub swept: Vec<u64>,
}

/// Why an instance is not sound.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum InstanceError {
    /// Nobody to drive.
    #[error("there is no robot")]
    NoRobots,
    /// Nothing to do.
    #[error("there is no cell to cover")]
    NothingToCover,
    /// A robot's start is not drivable.
    #[error("robot {robot} starts in cell {cell}, where its body does not fit")]
    StartBlocked {
        /// Number of the robot.
        robot: usize,
        /// Its cell.
        cell: Cell,
    },
    /// A cell to visit is not drivable.
    #[error("cell {0} is to be visited, but no body fits there")]
    VisitBlocked(Cell),
    /// A list does not fit the lattice.
    #[error("`{list}` has {found} entries; the lattice has {expected} cells")]
    WrongLength {
        /// Which list.
        list: &'static str,
        /// Its length.
        found: usize,
        /// The lattice's.
        expected: usize,
    },
    /// More robots than can stand on the floor.
    #[error("robot {robot} is one too many: there are only {cells} cells in which a robot can stand")]
    TooManyRobots {
        /// Number of the first robot too many.
        robot: usize,
        /// Cells to stand in.
        cells: usize,
    },
    /// A tool without a width.
    #[error("the tool is {0} m wide: expected a finite width above 0")]
    ToolWidth(f64),
    /// A weight that is no positive number.
    #[error("the weight of the move from cell {from} to {to} is {value}: expected a finite number above 0")]
    Weight {
        /// One end of the move.
        from: Cell,
        /// The other.
        to: Cell,
        /// What was given.
        value: f64,
    },
    /// A robot does not stand in its cell.
    #[error("robot {robot} stands at {point}, which is not in its cell {cell}")]
    StartElsewhere {
        /// Number of the robot.
        robot: usize,
        /// Its cell.
        cell: Cell,
        /// Its place.
        point: Point,
    },
    /// A battery that gives no time, or a time that is no number.
    #[error("`{key}` of the battery is {value} s: expected {expected}")]
    Battery {
        /// Which number.
        key: &'static str,
        /// What was given.
        value: f64,
        /// What is taken.
        expected: &'static str,
    },
    /// A charger where no robot can stand.
    #[error("station {station} is in cell {cell}, where the body does not fit: move it to free ground")]
    StationBlocked {
        /// Number of the station.
        station: usize,
        /// Its cell.
        cell: Cell,
    },
    /// A charger that is not in its cell, or cannot be driven to from the cell's centre.
    #[error("station {station} at {point} cannot be reached from the centre of its cell {cell}")]
    StationElsewhere {
        /// Number of the station.
        station: usize,
        /// Its cell.
        cell: Cell,
        /// Its place.
        point: Point,
    },
    /// A battery, and nowhere to charge it.
    #[error("robots have a battery, but there is no station to charge it: give one, or no battery")]
    NoStations,
    /// A speed or acceleration that is no positive number.
    #[error("`{0}` of the motion model is not a number above 0")]
    Motion(&'static str),
}

impl<'a> Instance<'a> {
    /// All drivable cells of a floor that can be reached from some start, to be covered by robots at rest.
    pub fn whole_floor(floor: &'a Floor, starts: Vec<Start>, motion: MotionModel, mode: Mode) -> Self {
        let blocked = vec![false; floor.lattice().len()];
        let mut instance = Self {
            floor,
            visit: blocked.clone(),
            blocked,
            starts,
            motion,
            mode,
            stations: Vec::new(),
            battery: None,
            weights: None,
            coverage_min: 0.99,
            incumbent: Vec::new(),
            orphans: Vec::new(),
            incumbent_lines: Vec::new(),
            orphan_lines: Vec::new(),
            swept: Vec::new(),
        };
        instance.visit = instance.reachable();
        instance
    }

    /// The same with the cells open in which robots stand: they are there, so it can be stood on.
    #[must_use]
    pub fn with_open_starts(&self) -> Self {
        let mut open = self.clone();
        for start in &self.starts {
            if let Some(index) = self.floor.lattice().index(start.cell) {
                open.blocked[index] = false;
            }
        }
        open
    }

    /// Row-major: number of the connected piece of open ground a cell belongs to; `u32::MAX` for closed ones.
    pub fn components(&self) -> Vec<u32> {
        let lattice = self.floor.lattice();
        let mut component = vec![u32::MAX; lattice.len()];
        let mut stack: Vec<Cell> = Vec::new();
        let mut count = 0;
        for cell in lattice.cells() {
            let index = lattice.index(cell).expect("cells() gives cells of the lattice");
            if component[index] != u32::MAX || !self.is_open(cell) {
                continue;
            }
            component[index] = count;
            stack.push(cell);
            while let Some(at) = stack.pop() {
                for next in self.neighbours(at) {
                    let index = lattice.index(next).expect("a neighbour is on the lattice");
                    if component[index] == u32::MAX {
                        component[index] = count;
                        stack.push(next);
                    }
                }
            }
            count += 1;
        }
        component
    }

    /// Whether a robot may stand in a cell now.
    pub fn is_open(&self, cell: Cell) -> bool {
        self.floor
            .lattice()
            .index(cell)
            .is_some_and(|index| self.floor.is_drivable(index) && !self.blocked[index])
    }

    /// The cells one move away that may be entered now.
    pub fn neighbours(&self, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
        self.floor.neighbours(cell).filter(|&next| self.is_open(next))
    }

    /// Row-major: the cells that some robot can reach (its own start included).
    pub fn reachable(&self) -> Vec<bool> {
        let lattice = self.floor.lattice();
        let mut reached = vec![false; lattice.len()];
        let mut stack: Vec<Cell> = Vec::new();
        for start in &self.starts {
            if let Some(index) = lattice.index(start.cell).filter(|&index| self.floor.is_drivable(index)) {
                reached[index] = true;
                stack.push(start.cell);
            }
        }
        while let Some(cell) = stack.pop() {
            for next in self.neighbours(cell) {
                let index = lattice.index(next).expect("a neighbour is on the lattice");
                if !reached[index] {
                    reached[index] = true;
                    stack.push(next);
                }
            }
        }
        reached
    }

    /// Time of a move between neighbouring cells at full speed, seconds.
    pub fn move_s(&self, from: Cell, to: Cell) -> f64 {
        let lattice = self.floor.lattice();
        let factor = self.weights.as_ref().map_or(1.0, |weights| weights.factor(lattice, from, to));
        factor * lattice.cell_m / self.motion.speed_m_per_s
    }

    /// Time to drive a line of points from standstill to standstill, seconds: that of the motion model, and what
    /// weights add to it. Weights count for moves from cell centre to cell centre. `heading_rad` as in
    /// [`MotionModel::path_s`].
    pub fn path_s(&self, points: &[Point], heading_rad: Option<f64>) -> f64 {
        let plain_s = self.motion.path_s(points, heading_rad);
        let Some(weights) = &self.weights else { return plain_s };
        let lattice = self.floor.lattice();
        let added: f64 = points
            .windows(2)
            .filter_map(|pair| Some((lattice.cell_at(pair[0])?, lattice.cell_at(pair[1])?)))
            .map(|(from, to)| weights.factor(lattice, from, to) - 1.0)
            .sum();
        plain_s + added * lattice.cell_m / self.motion.speed_m_per_s
    }

    /// The samples of the cell with this number that a plan which leaves the lattice has to sweep.
    pub fn wanted(&self, index: usize) -> u64 {
        self.floor.required(index) & !self.swept.get(index).copied().unwrap_or(0)
    }

    /// Where a robot stands.
    pub fn place(&self, start: &Start) -> Point {
        start.point.unwrap_or_else(|| self.center(start.cell))
    }

    /// Where a robot stands to charge.
    pub fn dock(&self, station: &Station) -> Point {
        station.point.unwrap_or_else(|| self.center(station.cell))
    }

    /// Centre of a cell, metres.
    pub fn center(&self, cell: Cell) -> Point {
        self.floor.lattice().center(cell)
    }

    /// Refuses what no planner could plan.
    ///
    /// # Errors
    ///
    /// [`InstanceError`], naming the first robot, cell or list that is wrong.
    pub fn check(&self) -> Result<(), InstanceError> {
        let lattice = self.floor.lattice();
        for (list, found) in [("visit", self.visit.len()), ("blocked", self.blocked.len())] {
            if found != lattice.len() {
                return Err(InstanceError::WrongLength { list, found, expected: lattice.len() });
            }
        }
        if !self.swept.is_empty() && self.swept.len() != lattice.len() {
            let (found, expected) = (self.swept.len(), lattice.len());
            return Err(InstanceError::WrongLength { list: "swept", found, expected });
        }
        check_motion(&self.motion)?;
        if let Some(weights) = &self.weights {
            weights.check(self.floor)?;
        }
        let tool_width_m = self.floor.tool_width_m();
        if !(tool_width_m.is_finite() && tool_width_m > 0.0) {
            return Err(InstanceError::ToolWidth(tool_width_m));
        }
        self.check_starts()?;
        self.check_power()?;
        if !self.visit.contains(&true) {
            return Err(InstanceError::NothingToCover);
        }
        match (0..lattice.len()).find(|&index| self.visit[index] && !self.floor.is_drivable(index)) {
            Some(index) => Err(InstanceError::VisitBlocked(lattice.cell(index))),
            None => Ok(()),
        }
    }

    fn check_starts(&self) -> Result<(), InstanceError> {
        if self.starts.is_empty() {
            return Err(InstanceError::NoRobots);
        }
        for (robot, start) in self.starts.iter().enumerate() {
            let cell = start.cell;
            if !self.floor.cell_is_drivable(cell) {
                return Err(InstanceError::StartBlocked { robot, cell });
            }
            if let Some(point) = start.point.filter(|&p| self.floor.lattice().cell_at(p) != Some(cell)) {
                return Err(InstanceError::StartElsewhere { robot, cell, point });
            }
        }
        let cells = (0..self.floor.lattice().len()).filter(|&index| self.floor.is_drivable(index)).count();
        if self.starts.len() > cells {
            return Err(InstanceError::TooManyRobots { robot: cells, cells });
        }
        Ok(())
    }

    fn check_power(&self) -> Result<(), InstanceError> {
        for (station, &Station { cell, point, queue_s }) in self.stations.iter().enumerate() {
            if !self.floor.cell_is_drivable(cell) {
                return Err(InstanceError::StationBlocked { station, cell });
            }
            if let Some(point) = point.filter(|&point| !self.can_dock(cell, point)) {
                return Err(InstanceError::StationElsewhere { station, cell, point });
            }
            check_time("queue_s of a station", queue_s)?;
        }
        let Some(battery) = &self.battery else { return Ok(()) };
        check_time("reserve_s", battery.reserve_s)?;
        check_time("charge_s", battery.charge_s)?;
        for left_s in self.starts.iter().filter_map(|start| start.charge_s) {
            check_time("charge_s of a start", left_s)?;
        }
        if battery.capacity_s.is_nan() || battery.budget_s() <= 0.0 {
            let expected = "more than the reserve";
            return Err(InstanceError::Battery { key: "capacity_s", value: battery.capacity_s, expected });
        }
        if self.stations.is_empty() { Err(InstanceError::NoStations) } else { Ok(()) }
    }

    fn can_dock(&self, cell: Cell, point: Point) -> bool {
        self.floor.lattice().cell_at(point) == Some(cell)
            && self.floor.segment_is_free(Segment::new(self.center(cell), point))
    }
}

fn check_time(key: &'static str, value: f64) -> Result<(), InstanceError> {
    let expected = "a finite number of at least 0";
    let sound = value.is_finite() && value >= 0.0;
    if sound { Ok(()) } else { Err(InstanceError::Battery { key, value, expected }) }
}

fn check_motion(motion: &MotionModel) -> Result<(), InstanceError> {
    if !(motion.speed_m_per_s > 0.0 && motion.speed_m_per_s.is_finite()) {
        return Err(InstanceError::Motion("speed_m_per_s"));
    }
    // The others may be infinite: ramps and turns that take no time, as in some of the papers.
    for (name, value) in [
        ("acceleration_m_per_s2", motion.acceleration_m_per_s2),
        ("angular_speed_rad_per_s", motion.angular_speed_rad_per_s),
        ("angular_acceleration_rad_per_s2", motion.angular_acceleration_rad_per_s2),
    ] {
        if value.is_nan() || value <= 0.0 {
            return Err(InstanceError::Motion(name));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_motion::MOTION;
    use crate::{PlanError, PlanOptions, plan};
    use terrain::Lattice;

    /// Three cells in a row, the last one blocked: what is said of an instance on them.
    fn refused(tool_width_m: f64, change: impl FnOnce(&mut Instance<'_>)) -> PlanError {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 3, rows: 1 };
        let floor = Floor::from_cells(lattice, &[true, true, false], 0.177, tool_width_m);
        let starts = vec![Start::at(Cell::new(0, 0))];
        let mut instance = Instance::whole_floor(&floor, starts, MOTION, Mode::Cover);
        change(&mut instance);
        plan(&instance, &PlanOptions::default()).unwrap_err()
    }

    #[test]
    fn bad_input_is_refused_by_robot_cell_or_move() {
        let start = |x| Start::at(Cell::new(x, 0));
        let weights = |value: f64| Some(EdgeWeights { right: vec![value; 3], up: vec![1.0; 3] });
        let said = [
            refused(0.5, |instance| instance.visit.fill(false)),
            refused(0.5, |instance| instance.starts[0] = start(2)),
            refused(0.5, |instance| instance.starts = vec![start(0), start(1), start(1)]),
            refused(0.0, |_| ()),
            refused(f64::NAN, |_| ()),
            refused(0.5, |instance| instance.weights = weights(0.0)),
            refused(0.5, |instance| instance.weights = weights(-1.0)),
            refused(0.5, |instance| instance.weights = weights(f64::NAN)),
            refused(0.5, |instance| instance.blocked[1] = true),
            refused(0.5, |instance| instance.starts.clear()),
            refused(0.5, |instance| instance.motion.speed_m_per_s = f64::NAN),
            refused(0.5, |instance| instance.starts[0].point = Some(Point::new(0.7, 0.2))),
        ];
        let words = [
            "there is no cell to cover",
            "robot 0 starts in cell (2, 0), where its body does not fit",
            "robot 2 is one too many: there are only 2 cells in which a robot can stand",
            "the tool is 0 m wide",
            "the tool is NaN m wide",
            "the weight of the move from cell (0, 0) to (1, 0) is 0",
            "the weight of the move from cell (0, 0) to (1, 0) is -1",
            "the weight of the move from cell (0, 0) to (1, 0) is NaN",
            "cell (1, 0) cannot be reached by any robot",
            "there is no robot",
            "`speed_m_per_s` of the motion model is not a number above 0",
            "robot 0 stands at {0.7, 0.2}, which is not in its cell (0, 0)",
        ];
        for (said, words) in said.iter().zip(words) {
            assert!(said.to_string().starts_with(words), "{said}");
        }
    }
}
