{{body}}
