"""Learn in about a minute what to command so that the robot walks at a velocity that is wanted.

python examples/07_learn.py [--rounds 3] [--seconds 3]

The policy is as small as can be: three numbers, the command. It begins with stepping in place,
and CMA-ES (the extra `studies`; the environment is the extra `gym`) seeks what the reward is for.
"""

import argparse

import cma
import gymnasium
import numpy as np

import drake_linefoot.lab.gym  # noqa: F401  # makes Linefoot-v0 known

GOAL = np.array([0.4, 0.1, 0.3])  # forward, left [m/s], turn rate [rad/s]
LIMITS = np.array([1.5, 0.5, 2.0])  # of the gait: an action of 1


def episode(env, command, seconds):
    """Return the mean reward of a step under one command, shape (3,)."""
    env.reset(seed=0)
    total = 0.0
    for _ in range(steps := round(seconds / 0.02)):
        _, reward, terminated, truncated, _ = env.step(np.clip(command / LIMITS, -1.0, 1.0))
        total += reward
        if terminated or truncated:
            break
    return total / steps


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=3.0, help="of an episode")
    options = parser.parse_args()
    env = gymnasium.make("Linefoot-v0", goal=GOAL)
    print(f"step in place: reward {episode(env, np.zeros(3), options.seconds):.3f} a step")
    settings = {"seed": 1, "popsize": 5, "verbose": -9}
    search = cma.CMAEvolutionStrategy(np.zeros(3), 0.25, settings)
    for round_ in range(options.rounds):
        tried = search.ask()
        search.tell(tried, [-episode(env, command, options.seconds) for command in tried])
        print(f"round {round_ + 1}: reward {-search.result.fbest:.3f}")
    print(f"learned: command {search.result.xbest.round(2)} for a goal of {GOAL}")


if __name__ == "__main__":
    main()
