// Which way a piece of a model is best cut on its way to four-sided ones.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/blocks/piece_mesh.h"
#include "cage/poll.h"

#include <optional>

namespace patchwright::cage {

/// What a piece can become without another cut.
enum class PieceForm {
    Block,    ///< a disc with four corners
    Polygon,  ///< a disc with three or five corners: as many blocks around a point
    Lens,     ///< a disc with two corners
    Drop,     ///< with one
    Disc,     ///< with none
    Sphere    ///< closed
};

/// Sides that bend far inward: a cut from their middle is needed, or they stay, as lines of a field
/// that part what is narrow on one side, such as the end of a fuselage, from what is wide.
enum class HollowSides { AreCut, Stay };

/// Nothing where a cut is needed.
/// @throw LayoutRefused when no cut can help
std::optional<PieceForm> form_of(const CutPiece& piece, HollowSides hollow = HollowSides::AreCut);

/// A cut to make.
struct Cut {
    PiecePath path;
    Parting start, end;
};

/// The cut that leaves the squarest pieces: it meets borders at right angles or goes on from
/// corners that need more than one quad, is short, and shares out corners.
/// @throw LayoutRefused when there is none
Cut best_cut(const CutPiece& piece, const PieceMesh& mesh, Poll& poll);

}  // namespace patchwright::cage
