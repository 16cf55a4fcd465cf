"""`python -m vpf_sim.cli`: the command line without its console script."""

from vpf_sim.cli import main

if __name__ == "__main__":
    main()
