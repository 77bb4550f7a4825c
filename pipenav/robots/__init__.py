"""What a robot is: its description, where its links are, what its laser reads."""
