// The list TRACED_LIST of the vertex, for trace/refill.glsl.
uint entry_count() { return list_head(TRACED_LIST, push.vertex).head.count; }
uint entry_at(uint place) { return list_entries(TRACED_LIST, push.vertex).at[place]; }
uint take_entries(uint count) { return atomicAdd(list_head(TRACED_LIST, push.vertex).head.taken, count); }
