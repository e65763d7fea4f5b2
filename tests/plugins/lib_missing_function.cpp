/// What a plugin meets that was built against a Polyarm with more in it.
double of_a_later_polyarm(double);

extern "C" const void* polyarm_plugin() {
  static double value = 1;
  value = of_a_later_polyarm(value);
  return &value;
}
