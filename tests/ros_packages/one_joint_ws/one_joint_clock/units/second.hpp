#pragma once
using Seconds = double;
