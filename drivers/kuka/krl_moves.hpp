#pragma once
/// Our KRL texts of forward mode: the program that makes moves, and what PolyarmEki has for it.
#include <string>

namespace polyarm::kuka {

/// PolyarmMoves.src: one robot program.
std::string krl_moves_program();
/// Declarations in PolyarmEki.dat.
std::string krl_moves_data();
/// Functions in PolyarmEki.src.
std::string krl_moves_requests();
/// Lines of PolyarmAnswer().
std::string krl_moves_answer();
/// Elements that EthernetKRL receives.
std::string krl_moves_receives();

}  // namespace polyarm::kuka
