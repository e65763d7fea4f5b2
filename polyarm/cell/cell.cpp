#include "polyarm/cell/cell.hpp"

#include "polyarm/cell/handlers.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {
std::vector<Handler> all_handlers() {
  std::vector<Handler> out = room_handlers();
  for (const auto& family : {cells_handlers(), text_handlers()}) out.insert(out.end(), family.begin(), family.end());
  return out;
}
}  // namespace

Cell::Cell(const CellFile& file, const description::Catalogue& catalogue, CellOptions options,
           Observer& observer)
    : inside_(std::make_unique<CellInside>(file, catalogue, std::move(options), observer,
                                           all_handlers())),
      view_(std::make_unique<CellView>(*inside_)) {}
Cell::~Cell() {
  inside_.reset();  // the recorder uses the view until the cell is destroyed
}

void Cell::tick(Nanoseconds now) {
  inside_->tick(now);
}
CellView& Cell::view() {
  return *view_;
}
Requests& Cell::requests() {
  return inside_->requests;
}
void Cell::add_observer(Observer& observer) {
  inside_->observers.add(observer);
}
void Cell::remove_observer(Observer& observer) {
  inside_->observers.remove(observer);
}
Recorder* Cell::recorder() {
  return inside_->recorder.get();
}
void Cell::set_recorder(std::unique_ptr<Recorder> recorder) {
  inside_->recorder = std::move(recorder);
}

CellInside& inside_of(Cell& cell) {
  return *cell.inside_;
}

}  // namespace polyarm::cell
