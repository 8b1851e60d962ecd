"""The paper's results rebuilt from case files, each beside what was published."""
