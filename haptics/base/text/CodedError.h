#pragma once

#include "haptics/base/InputError.h"
#include "haptics/base/text/MessageCode.h"

#include <string>

namespace midair::base
{

/// Input error that becomes a message of the code \a code.
class CodedError : public InputError
{
public:
    CodedError(MessageCode itsCode, const std::string& what) : InputError(what), code(itsCode) {}

    const MessageCode code;
};

} // namespace midair::base
