"""What the chapters measure: functions of resolved parameters, without text or figures.

Each takes JSON values as keywords and returns a :class:`~myostrain.reproduce.jobs.Found`. The outcome is kept
under the parameters and the code, so nothing else may enter.
"""
