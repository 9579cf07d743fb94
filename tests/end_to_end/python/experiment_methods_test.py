"""Staircases, QUEST and psychometric fits against closed forms, an exact Markov chain, brute force and finite differences."""

import math
import random
import unittest
import warnings
from statistics import NormalDist

import numpy as np
from thimble.experiment import ConstantStimuli, Fit, Quest, Staircase, fit, psychometric

PHI = NormalDist()


def stationary_levels(staircase, levels, proportion):
    """The stationary distribution over the levels of a staircase with `down`, whose steps are one level down and `weight` levels up: the chain
    of (level, correct answers in a row), solved as a linear system."""
    size, down, up = len(levels), staircase.down, round(staircase.weight)
    chain = np.zeros((size * down, size * down))
    for i, level in enumerate(levels):
        p = proportion(level)
        for run in range(down):
            state = i * down + run
            lower, higher = max(i - 1, 0), min(i + up, size - 1)
            chain[state, (lower * down if run == down - 1 else state + 1)] += p
            chain[state, higher * down] += 1 - p
    system = np.vstack([chain.T - np.eye(len(chain)), np.ones(len(chain))])
    solved = np.linalg.lstsq(system, np.append(np.zeros(len(chain)), 1.0), rcond=None)[0]
    return solved.reshape(size, down).sum(axis=1)


class Staircases(unittest.TestCase):
    def test_where_they_come_to_rest(self):
        """Levitt's 0.707 and 0.794, Kaernbach's 0.75: the mean of the exact chain, with a step that is small beside the slope. And the
        staircase visits the levels as often as the chain does."""
        levels = np.arange(0, 201) / 10.0
        for down, weight, target in ((1, 1, 0.5), (2, 1, 0.70711), (3, 1, 0.79370), (1, 3, 0.75)):
            def proportion(level):
                return 1 / (1 + math.exp(-(level - 10) / 2.5))

            staircase = Staircase(10.0, [0.1], down=down, weight=weight, reversals=10**9, most_trials=40_000, least=0, most=20)
            self.assertAlmostEqual(staircase.target, target, places=4)
            exact = stationary_levels(staircase, levels, proportion)
            mean = float(exact @ levels)
            self.assertAlmostEqual(proportion(mean), target, delta=0.01, msg=f"{down} down, weight {weight}")
            draw, visits = random.Random(down), np.zeros(len(levels))
            while not staircase.done:
                visits[round(staircase.level * 10)] += 1
                staircase.answer(draw.random() < proportion(staircase.level))
            visited = visits / visits.sum()
            print("[ figure ] %d down, weight %d: chain rests at %.4f, staircase at %.4f" % (down, weight, proportion(mean), proportion(float(visited @ levels))))
            self.assertAlmostEqual(float(visited @ levels), mean, delta=0.12)
            self.assertLess(0.5 * np.abs(visited - exact).sum(), 0.12)

    def test_an_example_by_hand(self):
        """Two down: the levels, the reversals and the mean of the runs, worked out on paper."""
        staircase = Staircase(10, [2, 1], down=2, reversals=5)
        levels = []
        for correct in (1, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 0, 1, 1):
            levels.append(staircase.level)
            staircase.answer(bool(correct))
        self.assertEqual(levels, [10, 10, 8, 8, 6, 7, 7, 6, 6, 7, 7, 6, 7, 7])
        self.assertEqual(staircase.reversal_levels, [6, 7, 6, 7, 6, 7])
        self.assertTrue(staircase.done)
        self.assertEqual(staircase.threshold(), (6.5, 0.0))
        with self.assertRaises(ValueError):
            staircase.answer(True)

    def test_factors_and_bounds(self):
        staircase = Staircase(0.4, [2.0], log=True, least=0.15, most=0.5)
        for correct, level in ((True, 0.2), (True, 0.15), (False, 0.3), (False, 0.5)):
            staircase.answer(correct)
            self.assertAlmostEqual(staircase.level, level)
        for bad in ({"start": 0.4, "steps": [0.9], "log": True}, {"start": 1, "steps": []}, {"start": 1, "steps": [0.1], "down": 0},
                    {"start": 1, "steps": [0.1], "most": 0.5}, {"start": -1, "steps": [2], "log": True}):
            with self.assertRaises(ValueError):
                Staircase(**bad)

    def test_numbers_that_are_refused(self):
        nan, inf = math.nan, math.inf
        for bad in ({"steps": [nan]}, {"steps": [inf]}, {"start": inf}, {"start": nan}, {"weight": nan}, {"weight": inf}, {"down": 1.5},
                    {"down": nan}, {"reversals": nan}, {"most_trials": nan}, {"most_trials": 0}, {"reversals": 1.5}, {"least": nan}, {"most": nan}):
            with self.assertRaises((TypeError, ValueError), msg=bad):
                Staircase(**{"start": 1, "steps": [0.1], **bad})
        for target in (0, 1, 1.0, 1.5, nan):
            with self.assertRaisesRegex(ValueError, f"target is {target}: give a proportion"):
                Staircase.weighted(1, [0.1], target=target)


class Quests(unittest.TestCase):
    def test_the_posterior_by_brute_force(self):
        """Products of probabilities instead of sums of logarithms, with epsilon by bisection."""
        for target, slope, guess, lapse in ((0.75, 3.5, 0.5, 0.01), (0.8, 1.3, 0.25, 0.05), (0.6, 2.0, 0.0, 0.02)):
            quest = Quest(0.2, sd=0.3, target=target, slope=slope, guess=guess, lapse=lapse, trials=25)

            def proportion(x, threshold, shift):
                return lapse * guess + (1 - lapse) * (1 - (1 - guess) * math.exp(-math.pow(10, slope * (x - threshold + shift))))

            low, high = -5.0, 5.0
            for _ in range(100):
                middle = (low + high) / 2
                low, high = (middle, high) if proportion(0, 0, middle) < target else (low, middle)
            draw = random.Random(3)
            product = [math.exp(-((t - math.log10(0.2)) ** 2) / (2 * 0.3**2)) for t in quest.grid]
            while not quest.done:
                x, correct = math.log10(quest.level), draw.random() < 0.7
                product = [old * (p if correct else 1 - p) for old, p in zip(product, (proportion(x, t, low) for t in quest.grid))]
                quest.answer(correct)
            expected = np.array(product) / math.fsum(product)
            np.testing.assert_allclose(quest.posterior, expected, rtol=1e-9, atol=1e-15)
            mean = float(expected @ quest.grid)
            at, error = quest.threshold()
            self.assertAlmostEqual(math.log10(at), mean, places=9)
            self.assertAlmostEqual(error, at * math.log(10) * math.sqrt(float(expected @ (quest.grid - mean) ** 2)), places=9)
            self.assertAlmostEqual(float(quest.probability(0.3, 0.3)), target, places=9)

    def test_it_finds_thresholds_with_the_error_that_it_tells(self):
        draw, errors, told = random.Random(11), [], []
        for _ in range(100):
            truth = 10 ** draw.gauss(math.log10(0.2), 0.4)
            quest = Quest(0.2, sd=0.4, trials=40, step=0.02)
            while not quest.done:
                quest.answer(draw.random() < float(quest.probability(quest.level, truth)))
            at, error = quest.threshold()
            errors.append(math.log10(at / truth))
            told.append(error / at / math.log(10))
        score = np.array(errors) / np.array(told)
        print("[ figure ] QUEST: errors of %.3f log10 units, told %.3f; mean score %.2f, its deviation %.2f" % (
            np.std(errors), np.mean(told), score.mean(), score.std()))
        self.assertLess(abs(score.mean()), 3 / math.sqrt(len(score)))
        self.assertAlmostEqual(score.std(), 1, delta=0.25)
        self.assertLess(np.std(errors), 0.1, "far below what was known before")

    def test_what_is_refused(self):
        for bad in ({"guess_level": 0}, {"guess_level": 1, "target": 0.5}, {"guess_level": 1, "target": 0.999}, {"guess_level": 1, "lapse": 0}):
            with self.assertRaises(ValueError):
                Quest(**bad)
        nan, inf = math.nan, math.inf
        for bad in ({"guess_level": nan}, {"guess_level": inf}, {"sd": nan}, {"sd": inf}, {"slope": nan}, {"slope": inf}, {"step": nan},
                    {"lapse": nan}, {"guess": nan}, {"guess": -0.1}, {"most": 0}, {"most": nan}, {"least": 10, "most": 1}, {"least": inf},
                    {"least": nan}, {"trials": nan}, {"trials": 0}):
            with self.assertRaises((TypeError, ValueError), msg=bad):
                Quest(**{"guess_level": 1, **bad})
        quest = Quest(1, least=0.9, most=1.1, trials=1)
        self.assertTrue(0.9 <= quest.level <= 1.1)
        quest.answer(True)
        with self.assertRaises(ValueError):
            quest.answer(True)


    def test_probabilities_far_below_the_threshold(self):
        """Without guesses they are proportional to level^slope, down to where a float ends."""
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            quest = Quest(1.0, sd=3, guess=0.0)
            ratio = float(quest.probability(1e-8, 1.0) / quest.probability(1e-9, 1.0))
            self.assertAlmostEqual(ratio / 10**3.5, 1, places=9)
            for sd, slope, lapse in ((3, 3.5, 0.01), (10, 10, 0.01), (3, 3.5, 1e-300)):
                for correct in (True, False):
                    quest = Quest(1.0, sd=sd, slope=slope, guess=0.0, lapse=lapse, trials=20)
                    while not quest.done:
                        quest.answer(correct)
                    self.assertTrue(np.isfinite([*quest.log_posterior, *quest.threshold()]).all())


def log_likelihood(function, x, k, n, parameters, guess):
    location, width, lapse = parameters
    p = psychometric(function, x, location, width, guess, lapse)
    return float(np.sum(k * np.log(p) + (n - k) * np.log(1 - p)))


class Fits(unittest.TestCase):
    CASES = (("weibull", 0.5, np.array([0.02, 0.05, 0.08, 0.12, 0.2, 0.4]), (0.1, 1.8, 0.03)),
             ("normal", "lapse", np.array([-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3]), (0.03, 0.12, 0.02)),
             ("normal", 0.25, np.array([1.0, 2, 3, 4, 5, 7, 9]), (4.0, 1.2, 0.04)))

    def test_exact_proportions_give_the_parameters_back(self):
        for function, guess, x, truth in self.CASES:
            n = np.full(len(x), 400.0)
            found = fit(x, n * psychometric(function, x, *truth[:2], guess, truth[2]), n, function=function, guess=guess)
            np.testing.assert_allclose([found.location, found.width, found.lapse], truth, rtol=1e-5)
            self.assertAlmostEqual(found.deviance, 0, places=6)
            self.assertEqual(found.freedom, len(x) - 3)

    def test_two_levels_in_closed_form(self):
        """Two levels and two parameters: the curve goes through both points, and the errors follow from those of two proportions."""
        x, k, n = np.array([-1.0, 2.0]), np.array([12.0, 70.0]), np.array([50.0, 80.0])
        p = k / n
        z = np.array([PHI.inv_cdf(v) for v in p])
        width = (x[1] - x[0]) / (z[1] - z[0])
        location = x[0] - width * z[0]
        found = fit(x, k, n, function="normal", guess=0.0, lapse=0.0)
        np.testing.assert_allclose([found.location, found.width], [location, width], rtol=1e-6)
        by_z = np.array([[-width * (1 + z[0] / (z[1] - z[0])), width * z[0] / (z[1] - z[0])], [width / (z[1] - z[0]), -width / (z[1] - z[0])]])
        variance_of_z = p * (1 - p) / n / np.array([PHI.pdf(v) for v in z]) ** 2
        expected = by_z @ np.diag(variance_of_z) @ by_z.T
        np.testing.assert_allclose(found.covariance[:2, :2], expected, rtol=1e-5)
        self.assertEqual(found.lapse_error, 0)
        at, error = found.level(0.5)
        self.assertAlmostEqual(at, location, places=6)
        self.assertAlmostEqual(error, math.sqrt(expected[0, 0]), places=6)

    def test_it_is_the_maximum_and_the_errors_are_its_curvature(self):
        """Against the likelihood by its definition: no step to any side is better, and finite differences of it, at proportions that the model
        has exactly, give the covariance."""
        draw = np.random.default_rng(5)
        for function, guess, x, truth in self.CASES:
            n = np.full(len(x), 200)
            k = draw.binomial(n, psychometric(function, x, *truth[:2], guess, truth[2]))
            found = fit(x, k, n, function=function, guess=guess)
            best = np.array([found.location, found.width, found.lapse])
            reached = log_likelihood(function, x, k, n, best, guess)
            self.assertAlmostEqual(found.log_likelihood, reached, places=6)
            for i in range(3):
                for sign in (-1, 1):
                    moved = best.copy()
                    moved[i] += sign * 1e-3 * max(abs(moved[i]), 0.01)
                    if 0 <= moved[2] <= 0.1:
                        self.assertLess(log_likelihood(function, x, k, n, moved, guess), reached)
            exact = n * psychometric(function, x, *truth[:2], guess, truth[2])
            model = fit(x, exact, n, function=function, guess=guess)
            step = 1e-3 * np.array([truth[0], truth[1], truth[2]])
            hessian = np.zeros((3, 3))
            for i in range(3):
                for j in range(3):
                    corners = [(a, b, log_likelihood(function, x, exact, n, np.array(truth) + a * step[i] * np.eye(3)[i] + b * step[j] * np.eye(3)[j], guess))
                               for a in (-1, 1) for b in (-1, 1)]
                    hessian[i, j] = sum(a * b * value for a, b, value in corners) / (4 * step[i] * step[j])
            np.testing.assert_allclose(np.linalg.inv(-hessian), model.covariance, rtol=2e-3, atol=1e-9)

    def test_few_trials_have_several_maxima(self):
        """Of 60 sets with 15 trials a level none has a better point on a grid than what was found."""
        random = np.random.default_rng(5)
        levels = np.array([0.02, 0.05, 0.08, 0.12, 0.2, 0.4])
        grid = [(location, width, lapse) for location in np.geomspace(0.02, 0.4, 30) for width in np.geomspace(0.5, 40, 25) for lapse in (0, 0.03, 0.06, 0.1)]
        curves = np.clip([psychometric("weibull", levels, *each[:2], 0.5, each[2]) for each in grid], 1e-12, 1 - 1e-12)
        for yes in [[7, 4, 14, 11, 14, 13], [6, 6, 12, 13, 15, 14], [5, 6, 7, 15, 14, 13],
                    *random.binomial(15, psychometric("weibull", levels, 0.1, 3.0, 0.5, 0.02), (60, 6))]:
            best = (np.log(curves) @ yes + np.log1p(-curves) @ (15 - np.array(yes))).max()
            self.assertGreater(fit(levels, yes, [15] * 6).log_likelihood, best - 1e-3, yes)

    def test_the_intervals_cover_the_truth(self):
        """200 sets of answers: 95 % intervals of the threshold. Of 200, 182 to 197 in 99.7 % of tests if the coverage is 95 %."""
        draw, x, n = np.random.default_rng(7), np.array([0.03, 0.05, 0.08, 0.12, 0.18, 0.3]), np.full(6, 60)
        truth = (0.1, 1.6, 0.02)
        level = truth[0] * (-math.log(1 - (0.75 - 0.5) / (0.5 - 0.02))) ** (1 / truth[1])
        covered = narrow = 0
        for _ in range(200):
            k = draw.binomial(n, psychometric("weibull", x, *truth[:2], 0.5, truth[2]))
            found = fit(x, k, n, lapse=truth[2])
            low, high = found.interval(0.75)
            covered += low <= level <= high
            narrow += 0 < high - low < level
        print("[ figure ] 95 %% intervals of the threshold: %d of 200 cover it" % covered)
        self.assertTrue(182 <= covered <= 197, covered)
        self.assertGreater(narrow, 180)

    def test_what_the_data_do_not_tell(self):
        apart = fit([1, 2, 3, 4], [0, 0, 20, 20], [20] * 4, function="normal", guess=0.0, lapse=0.0)
        self.assertTrue(2 <= apart.location <= 3)
        self.assertTrue(math.isnan(apart.location_error) and math.isnan(apart.level(0.5)[1]))
        for bad in (([1, 2], [1, 2], [1]), ([1, 2], [3, 1], [2, 2]), ([1, 1], [1, 1], [2, 2]), ([-1, 1], [1, 1], [2, 2])):
            with self.assertRaises(ValueError):
                fit(*bad)
        with self.assertRaises(ValueError):
            fit([1, 2], [1, 1], [2, 2], function="logistic")
        nan, inf = math.nan, math.inf
        for bad in ({"levels": [1, nan, 3]}, {"levels": [1, 2, inf]}, {"yes": [5, nan, 9]}, {"trials": [10, inf, 10]}, {"trials": [10, nan, 10]},
                    {"lapse": 0.6}, {"lapse": -1}, {"lapse": nan}, {"guess": 2}, {"guess": -0.1}, {"guess": nan}, {"guess": 0.95},
                    {"guess": "lapse", "lapse": 0.5}):
            with self.assertRaises((TypeError, ValueError), msg=bad):
                fit(**{"levels": [1, 2, 3], "yes": [5, 6, 9], "trials": [10] * 3, **bad})
        for call in (lambda: fit([1, 2], [1, 1], [2, 2], guess="laps"), lambda: psychometric("normal", 1, 0, 1, "laps")):
            with self.assertRaisesRegex(ValueError, 'guess is "laps": give a number or "lapse"'):
                call()
        with self.assertRaises(ValueError):
            Fit.level(apart, 1.5)

    def test_constant_stimuli(self):
        for levels, repeats in (([1, math.nan], 2), ([1, math.inf], 2), ([1, 2], 1.5), ([1, 2], math.nan), ([1, 2], 0)):
            with self.assertRaises((TypeError, ValueError), msg=(levels, repeats)):
                ConstantStimuli(levels, repeats, seed=9)
        method = ConstantStimuli([3, 1, 2], 4, seed=9)
        asked = []
        while not method.done:
            asked.append(method.level)
            method.answer(method.level > 1.5)
        self.assertEqual([sorted(asked[i : i + 3]) for i in range(0, 12, 3)], [[1, 2, 3]] * 4)
        again = ConstantStimuli([3, 1, 2], 4, seed=9)
        self.assertEqual(again.level, asked[0])
        levels, yes, trials = method.counts()
        self.assertEqual((list(levels), list(yes), list(trials)), ([1, 2, 3], [0, 4, 4], [4, 4, 4]))
        self.assertNotEqual(ConstantStimuli(range(20), 1, seed=1)._order, ConstantStimuli(range(20), 1, seed=2)._order)


if __name__ == "__main__":
    unittest.main()
