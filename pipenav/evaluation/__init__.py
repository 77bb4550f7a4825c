"""Many episodes in many pipes, stage by stage, counted, and reported beside the thesis."""
