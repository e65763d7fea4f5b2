#pragma once
/// References to the parts of a cell that jogging needs.

namespace polyarm::cell {

class CellData;
class ContactWatch;
class Jogging;
class Machine;
class Motions;
class Programs;
struct CellSetup;

struct JogOwners {
  const CellSetup& setup;
  Machine& machine;
  CellData& data;
  const ContactWatch& contacts;
  Motions& motions;
  const Programs& programs;
  Jogging& jogging;
};

}  // namespace polyarm::cell
