//! A real-coded genetic algorithm, as a solver of argmin.

use argmin::core::{
    Error, Executor, KV, PopulationState, Problem as ArgminProblem, Solver as ArgminSolver, TerminationReason,
    TerminationStatus,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::objective::{BudgetSpent, Objective, project, run, stop_of};
use super::variation::{Individual, crossover, gaussian, mutate};
use super::{Options, Problem, Report, Solver, Stop};

const POPULATION: usize = 60;
/// The best individuals that survive unchanged.
const ELITE: usize = 2;
/// First width of the mutations, relative to the box.
const WIDTH: f64 = 0.03;
/// Generations without progress after which the population is renewed.
const PATIENCE: usize = 60;
/// Renewals in a row without gain after which it stops.
const RENEWALS: usize = 2;
/// Half side of the box of a parameter without bounds, relative to its start.
const UNBOUNDED_REACH: f64 = 4.0;

/// A generational genetic algorithm: binary tournaments, blend crossover,
/// self-adaptive Gaussian mutation, two elite individuals.
///
/// Half of the first population is scattered narrowly around the start, half
/// over the whole box. When it stagnates all but the best are replaced by new
/// random individuals; when that gains nothing twice in a row, it stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct Genetic {
    /// Budget and tolerance.
    pub options: Options,
}

impl Solver for Genetic {
    fn name(&self) -> &'static str {
        "ga"
    }

    fn solve(&self, problem: &dyn Problem, start: &[f64], seed: u64) -> Report {
        run(problem, start, self.options, |objective| evolve(objective, seed, 0))
    }
}

/// Runs until it stagnates or another generation would leave fewer than
/// `reserve` evaluations.
pub(super) fn evolve(objective: &Objective, seed: u64, reserve: usize) -> Stop {
    let evolution = Evolution::new(objective, seed, reserve);
    match Executor::new(objective, evolution).ctrlc(false).run() {
        Ok(result) => result.solver.stop.unwrap_or(Stop::NoProgress),
        Err(error) => stop_of(&error),
    }
}

type Population = PopulationState<Individual, f64>;

struct Evolution {
    rng: Xoshiro256PlusPlus,
    /// Where new individuals are drawn from, and its lengths.
    domain: Vec<(f64, f64)>,
    ranges: Vec<f64>,
    reserve: usize,
    /// Best cost when progress was last made, generations since then, best cost
    /// at the last renewal, and renewals in a row that gained nothing.
    reference: f64,
    stagnant: usize,
    renewed_at: f64,
    in_vain: usize,
    stop: Option<Stop>,
}

impl Evolution {
    fn new(objective: &Objective, seed: u64, reserve: usize) -> Self {
        let (start, cost) = objective.best();
        let side = |(&x, &(lo, hi)): (&f64, &(f64, f64))| {
            if (hi - lo).is_finite() {
                return (lo, hi);
            }
            let reach = UNBOUNDED_REACH * x.abs().max(1.0);
            (lo.max(x - reach), hi.min(x + reach))
        };
        let domain: Vec<_> = start.iter().zip(objective.problem.bounds()).map(side).collect();
        Self {
            rng: Xoshiro256PlusPlus::seed_from_u64(seed),
            ranges: domain.iter().map(|(lo, hi)| hi - lo).collect(),
            domain,
            reserve,
            reference: cost,
            stagnant: 0,
            renewed_at: f64::INFINITY,
            in_vain: 0,
            stop: None,
        }
    }

    fn can_afford_a_generation(&self, objective: &Objective) -> bool {
        objective.remaining() >= self.reserve + POPULATION
    }

    /// An individual from anywhere in the domain.
    fn stranger(&mut self) -> Individual {
        let draw = |(lo, hi): &(f64, f64)| lo + self.rng.random::<f64>() * (hi - lo);
        let genes = self.domain.iter().map(draw).collect();
        Individual { genes, width: WIDTH, cost: f64::INFINITY }
    }

    /// A slightly different copy.
    fn relative(&mut self, of: &Individual) -> Individual {
        let mut relative = of.clone();
        for (x, range) in relative.genes.iter_mut().zip(&self.ranges) {
            *x += WIDTH * range * gaussian(&mut self.rng);
        }
        relative
    }

    /// Fills the population up with new individuals, half of them near its first.
    fn populate(&mut self, objective: &Objective, population: &mut Vec<Individual>) -> Result<(), BudgetSpent> {
        while population.len() < POPULATION {
            let mut new =
                if population.len() < POPULATION / 2 { self.relative(&population[0].clone()) } else { self.stranger() };
            express(objective, &mut new)?;
            population.push(new);
        }
        population.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        Ok(())
    }

    /// The better of two individuals drawn at random.
    fn tournament<'a>(&mut self, population: &'a [Individual]) -> &'a Individual {
        let mut draw = || self.rng.random_range(0..population.len());
        // The population is sorted by cost.
        let winner = draw().min(draw());
        &population[winner]
    }

    /// The next generation, sorted by cost.
    fn breed(&mut self, objective: &Objective, parents: &[Individual]) -> Result<Vec<Individual>, BudgetSpent> {
        let mut next = parents[..ELITE].to_vec();
        while next.len() < POPULATION {
            let pair = [self.tournament(parents), self.tournament(parents)];
            for mut child in crossover(pair, &mut self.rng) {
                mutate(&mut child, &self.ranges, &mut self.rng);
                express(objective, &mut child)?;
                next.push(child);
            }
        }
        next.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        Ok(next)
    }

    /// Counts generations without progress; whether to renew the population.
    fn stagnates(&mut self, cost: f64, tolerance: f64) -> bool {
        if self.reference - cost > tolerance * cost {
            self.reference = cost;
            self.stagnant = 0;
            return false;
        }
        self.stagnant += 1;
        if self.stagnant < PATIENCE {
            return false;
        }
        self.stagnant = 0;
        let gain = self.renewed_at - cost;
        self.renewed_at = cost;
        self.in_vain = if gain > tolerance * cost { 0 } else { self.in_vain + 1 };
        if self.in_vain == RENEWALS {
            self.stop = Some(Stop::CostTolerance);
        }
        self.stop.is_none()
    }
}

/// Moves an individual into the bounds and computes its cost.
fn express(objective: &Objective, individual: &mut Individual) -> Result<(), BudgetSpent> {
    project(&mut individual.genes, objective.problem.bounds());
    individual.cost = objective.cost(&individual.genes)?;
    Ok(())
}

impl<'a> ArgminSolver<&'a Objective<'a>, Population> for Evolution {
    fn name(&self) -> &str {
        "Genetic algorithm"
    }

    fn init(
        &mut self,
        problem: &mut ArgminProblem<&'a Objective<'a>>,
        state: Population,
    ) -> Result<(Population, Option<KV>), Error> {
        let population = problem.problem("cost_count", |objective| {
            let (genes, cost) = objective.best();
            let mut population = vec![Individual { genes, width: WIDTH, cost }];
            if self.can_afford_a_generation(objective) {
                self.populate(objective, &mut population)?;
            }
            Ok(population)
        })?;
        Ok((renew(state, population), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut ArgminProblem<&'a Objective<'a>>,
        mut state: Population,
    ) -> Result<(Population, Option<KV>), Error> {
        let mut population = state.take_population().unwrap_or_default();
        let population = problem.problem("cost_count", |objective| {
            if !self.can_afford_a_generation(objective) {
                self.stop = Some(Stop::Budget);
                return Ok(population);
            }
            if objective.is_perfect(population[0].cost) {
                self.stop = Some(Stop::CostTolerance);
                return Ok(population);
            }
            objective.iterations.set(objective.iterations.get() + 1);
            if self.stagnates(population[0].cost, objective.options.cost_tolerance) {
                population.truncate(1);
                self.populate(objective, &mut population)?;
                return Ok(population);
            }
            Ok(self.breed(objective, &population)?)
        })?;
        Ok((renew(state, population), None))
    }

    fn terminate(&mut self, _state: &Population) -> TerminationStatus {
        match &self.stop {
            Some(stop) => TerminationStatus::Terminated(TerminationReason::SolverExit(stop.to_string())),
            None => TerminationStatus::NotTerminated,
        }
    }
}

/// The state with a new population, which is sorted by cost.
fn renew(state: Population, population: Vec<Individual>) -> Population {
    let best = population[0].clone();
    state.cost(best.cost).individual(best).population(population)
}
