#pragma once
#define RCUTILS_PUBLIC
#define RCUTILS_LOCAL
#define RCUTILS_WARN_UNUSED __attribute__((warn_unused_result))
#define RCUTILS_STRINGIFY_IN_(text) #text
#define RCUTILS_STRINGIFY(text) RCUTILS_STRINGIFY_IN_(text)
#define RCUTILS_UNUSED(name) static_cast<void>(name)
#define RCUTILS_LIKELY(value) __builtin_expect(static_cast<bool>(value), 1)
#define RCUTILS_UNLIKELY(value) __builtin_expect(static_cast<bool>(value), 0)
