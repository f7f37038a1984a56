#pragma once

#include <string>
#include <vector>

namespace midair::samples
{

/// What midair-sweep was asked for.
struct SweepArguments
{
    std::string table;
    std::string out;
    std::string shard = "1/1";
    bool times = false;     ///< times that solves took, too: other bytes each time
    bool overwrite = false; ///< whatever is there
    bool quiet = false;
};

/// Solves a shard's rows. With a single shard \a arguments.out becomes the table of results, else
/// the part. Goes on with a part that is there. Returns 0, or 1 if a row couldn't be solved. Throws
/// base::InputError.
int sweep(const SweepArguments& arguments);

/// Joins \a parts to a table of results. Throws base::InputError.
void mergeSwept(const std::vector<std::string>& parts, const std::string& out, bool overwrite);

} // namespace midair::samples
