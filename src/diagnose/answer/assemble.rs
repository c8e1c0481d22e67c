//! TODO-doc

use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::SET_ASIDE_REMARK_PERCENT;

/// Both with the same stretches in their fits: see [`Workspace::alike`].
pub(crate) fn shown_alike(
    workspace: &Workspace,
    before: &ModelState,
    after: &ModelState,
) -> Result<(ModelState, ModelState), DiagnoseError> {
    let mut shown = (before.clone(), after.clone());
    let train = workspace.alike(&workspace.train, [&before.train, &after.train])?;
    [shown.0.train, shown.1.train] = train;
    if let (Some(side), Some(a), Some(b)) = (&workspace.held_out, &before.held_out, &after.held_out)
    {
        let held_out = workspace.alike(side, [a, b])?;
        [shown.0.held_out, shown.1.held_out] = held_out.map(Some);
    }
    Ok(shown)
}

/// How much of either side counts for nothing, where that is much.
pub(crate) fn misread(shown: &ModelState) -> Option<String> {
    let held_out = shown.held_out.as_ref().map_or(0.0, Fitted::aside);
    let (train, held_out) = (100.0 * shown.train.aside(), 100.0 * held_out);
    (train.max(held_out) > SET_ASIDE_REMARK_PERCENT).then(|| {
        format!("{train:.0} % of the fitted readings and {held_out:.0} % of those kept out count for nothing: an event near them was overlooked or is in the wrong place")
    })
}
