"""Rain outside the car: falling drops, wet road, spray."""
