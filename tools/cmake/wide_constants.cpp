// GCC 12.2 pushes a constant struct {x, x, 0, 0} by value as {x, x, x, x} where AVX-512 is enabled (-O2 -mavx512f): the
// constant becomes one wide integer without its leading zeros, found to repeat itself. 0: the compiler does it right.
struct Four {
  double a, b, c, d;
};
[[gnu::noinline]] double sum(Four x) { return x.c + x.d; }
int main() { return sum({1e-8, 1e-8, 0, 0}) == 0 ? 0 : 1; }
