"""``python -m train.team`` follows the recipe of the one policy."""

from train.team.team_recipe import main

main()
