using System;
using System.Globalization;
using UnityEngine;
using UnityEngine.Events;

namespace Snapfit.Unity
{
    /// <summary>A text for some component to show: bind it in the inspector, for example to the
    /// text of a TMP_Text. So no package for texts is needed here.</summary>
    [Serializable]
    public sealed class TextEvent : UnityEvent<string>
    {
    }

    /// <summary>Shows the step that is to be taken now.</summary>
    [AddComponentMenu("Snapfit/Step Panel")]
    public sealed class StepPanel : MonoBehaviour
    {
        [SerializeField] private StepGuide guide;

        [Tooltip("What the title says when nothing is left to do.")]
        [SerializeField] private string finishedTitle = "Done";

        [SerializeField] private TextEvent title = new TextEvent();
        [SerializeField] private TextEvent text = new TextEvent();

        [Tooltip("Steps that were taken, and what sits wrong.")]
        [SerializeField] private TextEvent note = new TextEvent();

        private string shownNote;
        private string notedBootId;
        private long notedRevision;

        /// <summary>Whose step is shown.</summary>
        public StepGuide Guide
        {
            get { return guide; }
            set { guide = value; }
        }

        /// <summary>Gets the title.</summary>
        public TextEvent Title
        {
            get { return title; }
        }

        /// <summary>Gets the instruction.</summary>
        public TextEvent Text
        {
            get { return text; }
        }

        /// <summary>Gets how far the assembly is, and what sits wrong.</summary>
        public TextEvent Note
        {
            get { return note; }
        }

        private void OnEnable()
        {
            if (guide != null)
            {
                guide.StepChanged += Show;
                Show(guide.Current);
            }
        }

        private void OnDisable()
        {
            if (guide != null)
            {
                guide.StepChanged -= Show;
            }
        }

        private void Update()
        {
            SnapfitConnection connection = guide == null ? null : guide.Connection;
            PoseSnapshot latest = connection == null ? null : connection.Latest;
            if (latest == null || !latest.HasAssembly)
            {
                return;
            }
            // Texts are made when something changed, not every frame.
            AssemblySummary assembly = latest.Assembly;
            if (assembly.Revision == notedRevision && latest.BootId == notedBootId)
            {
                return;
            }
            notedRevision = assembly.Revision;
            notedBootId = latest.BootId;
            string next = NoteOf(assembly);
            if (next != shownNote)
            {
                shownNote = next;
                note.Invoke(next);
            }
        }

        private void Show(Step step)
        {
            bool isFinished = step == null && guide.IsFinished;
            title.Invoke(step != null ? step.Title : isFinished ? finishedTitle : "");
            text.Invoke(step != null ? step.Text : "");
        }

        private static string NoteOf(AssemblySummary assembly)
        {
            string done = string.Format(
                CultureInfo.InvariantCulture, "{0} done", assembly.FinishedSteps.Count);
            foreach (Misassembly wrong in assembly.Misassemblies)
            {
                done += "\n" + wrong.Part + ": " + wrong.Kind.Replace('_', ' ');
            }
            return done;
        }
    }
}
