#pragma once
/// `polyarm run`: writes every request that changes something to the audit log of this user.
#include <memory>

#include "polyarm/inside/view.hpp"
#include "polyarm/server/pendant.hpp"
#include "polyarm/users/audit_log.hpp"

namespace polyarm::apps {

/// Null if the log cannot be written; a note says why, and the cell runs on.
std::unique_ptr<users::AuditLog> open_audit(cell::Observer& observer);
/// Logs the requests of this cell. The log and the pendant (or null) must outlive it.
void audit(cell::CellView cell, users::AuditLog& log, const server::Pendant* pendant);

}  // namespace polyarm::apps
