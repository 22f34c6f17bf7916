"""A Gymnasium environment, the extra `gym`; importing this makes `Linefoot-v0` known to it.

So does its name with the module in front, `gymnasium.make("drake_linefoot.lab.gym:Linefoot-v0")`.
"""

import gymnasium

NAME, STEPS = "Linefoot-v0", 500  # of an episode at most

gymnasium.register(NAME, "drake_linefoot.lab.gym.env:LinefootEnv", max_episode_steps=STEPS)
