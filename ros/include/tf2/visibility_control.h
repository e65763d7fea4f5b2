#pragma once
#define TF2_PUBLIC
#define TF2_LOCAL
#define TF2_PUBLIC_TYPE
