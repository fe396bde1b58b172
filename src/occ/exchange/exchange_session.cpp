#include "occ/exchange/exchange_session.h"

#include <patchwright/base/error.h>

#include <IGESControl_Controller.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Controller.hxx>
#include <TopoDS_Shape.hxx>
#include <XSAlgo.hxx>
#include <fmt/format.h>

#include <iostream>

namespace patchwright::occ {

namespace {

std::mutex& exchange_mutex() {
    static std::mutex mutex;
    return mutex;
}

class LeavingShapes : public XSAlgo_AlgoContainer {
  public:
    TopoDS_Shape ProcessShape(const TopoDS_Shape& shape, double /*precision*/, double /*most*/,
                              Standard_CString /*resource*/, Standard_CString /*sequence*/,
                              Handle(Standard_Transient) & /*info*/,
                              const Message_ProgressRange& /*progress*/,
                              bool /*non_manifold*/) const override {
        return shape;
    }
};

}  // namespace

ExchangeSession::MutedOutput::MutedOutput()
    : buffer(std::cout.rdbuf(nullptr)), printers(Message::DefaultMessenger()->Printers()) {
    Message::DefaultMessenger()->ChangePrinters().Clear();
}

ExchangeSession::MutedOutput::~MutedOutput() {
    Message::DefaultMessenger()->ChangePrinters() = printers;
    std::cout.rdbuf(buffer);
}

ExchangeSession::ExchangeSession() : lock_(exchange_mutex()) {
    // Parameters exist only after the controllers do.
    STEPControl_Controller::Init();
    IGESControl_Controller::Init();
    set("xstep.cascade.unit", "MM");
    algorithms_ = XSAlgo::AlgoContainer();
}

ExchangeSession::~ExchangeSession() {
    XSAlgo::SetAlgoContainer(algorithms_);
    for (auto saved = saved_.rbegin(); saved != saved_.rend(); ++saved) {
        Interface_Static::SetCVal(saved->parameter.c_str(), saved->value.c_str());
    }
}

void ExchangeSession::leave_shapes() { XSAlgo::SetAlgoContainer(new LeavingShapes); }

void ExchangeSession::save(const std::string& parameter) {
    if (!Interface_Static::IsPresent(parameter.c_str())) {
        throw base::InvalidArgument(fmt::format("the CAD kernel has no parameter '{}'", parameter));
    }
    saved_.push_back({parameter, Interface_Static::CVal(parameter.c_str())});
}

void ExchangeSession::set(const std::string& parameter, const std::string& value) {
    save(parameter);
    if (!Interface_Static::SetCVal(parameter.c_str(), value.c_str())) {
        throw base::InvalidArgument(
            fmt::format("the CAD kernel refuses {} = '{}'", parameter, value));
    }
}

void ExchangeSession::set(const std::string& parameter, int value) {
    save(parameter);
    if (!Interface_Static::SetIVal(parameter.c_str(), value)) {
        throw base::InvalidArgument(
            fmt::format("the CAD kernel refuses {} = {}", parameter, value));
    }
}

}  // namespace patchwright::occ
