#pragma once
/// nlohmann/json.hpp as it is precompiled: its literals (`"{}"_json`) are declared and not defined. Their
/// definitions are plain inline functions, so a compiler that loads the precompiled header would instantiate the
/// parser behind them in each source file, used or not. A version that writes them in another way is included as
/// it is.
#define _json(...) _json(__VA_ARGS__); template <class> auto polyarm_undefined_json(__VA_ARGS__)
#define _json_pointer(...) _json_pointer(__VA_ARGS__); template <class> auto polyarm_undefined_json_pointer(__VA_ARGS__)
#include <nlohmann/json.hpp>
#undef _json
#undef _json_pointer
