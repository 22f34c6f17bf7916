"""What the model of the MPC, its horizon, and errors in one thing at a time bring, under pushes."""
