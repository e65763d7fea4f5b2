#include <algorithm>
#include <cmath>

#include "drivers/ur/far_services.hpp"

namespace polyarm::ur {

namespace {

void reply(FarRtde::Client& client, PackageType type, const wire::Writer& payload) {
  if (!wire::send_frame(client.socket.number(), frame(type, payload))) client.gone = true;
}

wire::Writer byte(std::uint64_t value) {
  wire::Writer out;
  out.u8(value);
  return out;
}

std::string text_of(Bytes bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

void FarRtde::serve() {
  service_.serve([](Client&) {},
                 [this](Client& client, Bytes bytes) {
                   return client.frames.feed(bytes, [&](PackageType type, Bytes payload) {
                     client.gone |= !take(client, type, payload);
                   });
                 });
}

bool FarRtde::take(Client& client, PackageType type, Bytes payload) {
  switch (type) {
    case PackageType::protocol_version: {
      const int wanted = wire::Reader(payload).u16();
      const bool fine = payload.size() == 2 && wanted >= 1 && wanted <= 2 && !faults_.wrong_version;
      if (fine) client.protocol = wanted;
      reply(client, type, byte(fine));
      return true;
    }
    case PackageType::controller_version: {
      const MachineOptions& o = machine_.options();
      wire::Writer out;
      out.u32(static_cast<std::uint64_t>(o.major)).u32(static_cast<std::uint64_t>(o.minor));
      out.u32(static_cast<std::uint64_t>(o.bugfix)).u32(0);
      reply(client, type, out);
      return true;
    }
    case PackageType::setup_outputs:
      set_up_outputs(client, payload);
      return true;
    case PackageType::setup_inputs:
      set_up_inputs(client, payload);
      return true;
    case PackageType::start: {
      const bool ready = !client.output_recipe.types.empty() || !client.inputs.empty();
      client.started = ready;
      reply(client, type, byte(ready));
      return true;
    }
    case PackageType::pause:
      client.started = false;
      reply(client, type, byte(1));
      return true;
    case PackageType::data:
      take_inputs(client, payload);
      return true;
    case PackageType::text:
      return true;
  }
  return false;  // no package of RTDE
}

void FarRtde::set_up_outputs(Client& client, Bytes payload) {
  wire::Reader in(payload);
  double wanted = 125;
  if (client.protocol >= 2) wanted = in.f64();
  if (!(wanted > 0)) wanted = 1;
  client.divisor = std::max(1, static_cast<int>(std::lround(rate_ / std::min(wanted, rate_))));
  client.outputs = split_names(text_of(in.rest()));
  client.output_recipe = {};
  client.output_recipe.id = 1;
  std::string types;
  bool known = !client.outputs.empty();
  for (const std::string& name : client.outputs) {
    const FieldType* type = machine_.reports_instead(name) ? find_type("DOUBLE") : find_output(name);
    types += (types.empty() ? "" : ",") + std::string(type ? type->name : "NOT_FOUND");
    known = known && type;
    if (type) client.output_recipe.add(*type);
  }
  if (!known) client.output_recipe = {};
  wire::Writer out;
  if (client.protocol >= 2) out.u8(known);
  reply(client, PackageType::setup_outputs, out.text(types));
}

bool FarRtde::is_taken(const Client& client, const std::string& input) {
  if (faults_.second_client) return true;
  for (const auto& other : service_.clients())
    for (const Client::Inputs& set : other->inputs)
      if (other.get() != &client && !other->gone &&
          std::find(set.names.begin(), set.names.end(), input) != set.names.end())
        return true;
  return false;
}

void FarRtde::set_up_inputs(Client& client, Bytes payload) {
  Client::Inputs set;
  set.names = split_names(text_of(payload));
  std::string types;
  bool fine = !set.names.empty() && client.inputs.size() < 255;
  for (const std::string& name : set.names) {
    const FieldType* type = find_input(name);
    const std::string word = !type                    ? "NOT_FOUND"
                             : is_taken(client, name) ? "IN_USE"
                                                      : std::string(type->name);
    types += (types.empty() ? "" : ",") + word;
    fine = fine && type && word != "IN_USE";
    if (type) set.recipe.add(*type);
  }
  wire::Writer out;
  if (fine) {
    set.recipe.id = static_cast<std::uint8_t>(client.inputs.size() + 1);
    out.u8(set.recipe.id);
    client.inputs.push_back(std::move(set));
  } else {
    out.u8(0);
  }
  reply(client, PackageType::setup_inputs, out.text(types));
}

void FarRtde::take_inputs(Client& client, Bytes payload) {
  wire::Reader in(payload);
  const std::size_t id = in.u8();
  if (id == 0 || id > client.inputs.size()) return;
  const Client::Inputs& set = client.inputs[id - 1];
  std::vector<double> values(set.recipe.elements);
  if (!decode(set.recipe, in.rest(), values)) return;
  std::size_t at = 0;
  for (std::size_t i = 0; i < set.names.size(); ++i) {
    machine_.input(set.names[i], values[at]);
    at += set.recipe.types[i]->elements;
  }
  machine_.apply_inputs();
}

std::vector<std::uint8_t> FarRtde::package_of(Client& client) {
  std::vector<double> values;
  for (std::size_t i = 0; i < client.outputs.size(); ++i) {
    std::vector<double> one = machine_.value(client.outputs[i]);
    one.resize(client.output_recipe.types[i]->elements);
    values.insert(values.end(), one.begin(), one.end());
  }
  wire::Writer out;
  if (client.protocol >= 2) out.u8(client.output_recipe.id);
  encode(client.output_recipe, values, out);
  return frame(PackageType::data, out);
}

void FarRtde::send(Client& client) {
  client.kept.push_back(package_of(client));
  if (faults_.late > 0) {
    --faults_.late;
    return;
  }
  if (faults_.reorder > 0) {
    if (client.kept.size() < 2) return;
    --faults_.reorder;
    std::swap(client.kept[0], client.kept[1]);
  }
  for (auto& package : client.kept) {
    const int times = faults_.duplicate > 0 ? 2 : 1;
    faults_.duplicate -= times - 1;
    if (faults_.garbage) package[0] = package[1] = 0;
    faults_.garbage = false;
    for (int i = 0; i < times; ++i)
      if (!wire::send_frame(client.socket.number(), package)) client.gone = true;
  }
  sent_time_ = machine_.time();
  client.kept.clear();
}

void FarRtde::send(std::uint64_t cycle) {
  if (faults_.silent) return;
  for (const auto& client : service_.clients())
    if (client->started && !client->output_recipe.types.empty() &&
        cycle % static_cast<unsigned>(client->divisor) == 0)
      send(*client);
}

}  // namespace polyarm::ur
