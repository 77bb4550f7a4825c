"""How pipes and robots are drawn: one style, dimensions, corner, route, scene from above."""
